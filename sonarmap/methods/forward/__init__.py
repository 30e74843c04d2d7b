"""Forward models: maps that explain the readings as a whole, not cell by cell."""
