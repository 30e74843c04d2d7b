"""Compiled loops of the core, open to the other packages; each has a slow twin in the tests."""
