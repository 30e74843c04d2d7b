"""Reading filters: what they make of each reading of a log. One file a filter."""
