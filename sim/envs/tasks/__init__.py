"""What robots are asked to do: explore, navigate, follow a wall."""
