"""Physics of many robots with simple cones at once, in a few compiled calls."""
