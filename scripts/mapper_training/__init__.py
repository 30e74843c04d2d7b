"""What `scripts/train_mapper.py` is made of: data, network, calibration, filter, weights, card."""
