"""What moves a robot in a world and casts its rays."""
