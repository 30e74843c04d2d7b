"""Mapping methods: from a log to an occupancy map."""
