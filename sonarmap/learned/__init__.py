"""The learned mapper: evidence of a log in channels, a small network over them, its weights."""
