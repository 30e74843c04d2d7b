"""Sonars: when they fire, and what they detect."""
