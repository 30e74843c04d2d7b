"""Many whole drives, compiled, on all cores."""
