"""The maps that robots build as they drive."""
