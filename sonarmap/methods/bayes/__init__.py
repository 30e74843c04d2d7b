"""Bayesian updating with inverse sensor models."""
