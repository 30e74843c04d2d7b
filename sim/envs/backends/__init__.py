"""What moves the robots of an environment and lets them hear."""
