"""Maps and readings judged by the truth."""
