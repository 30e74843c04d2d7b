"""Frames of an episode: drawn, shown in a window, kept as a film."""
