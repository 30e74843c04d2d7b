"""Many whole drives with simple cones, compiled, on all cores."""
