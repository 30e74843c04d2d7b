"""One style a file; which ones there are stands in `worlds/generation/catalogue.py`."""
