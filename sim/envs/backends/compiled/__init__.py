"""Many robots with simple cones at once, in a few compiled calls."""
