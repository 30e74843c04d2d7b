"""Drives: one, many, and what is recorded of them."""
