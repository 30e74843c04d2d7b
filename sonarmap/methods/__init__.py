"""Mapping methods: from a log to an occupancy map. One file, or folder, a method."""
