"""Bayesian updating of an occupancy grid with an inverse sensor model."""
