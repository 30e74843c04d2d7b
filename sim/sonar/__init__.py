"""Sonars: when they fire, and what they hear."""
