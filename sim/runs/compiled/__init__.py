"""Whole drives on `segments`, compiled: what `sim.runs.plain` does, many times faster."""
