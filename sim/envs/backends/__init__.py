"""What moves the robots of an environment and fires their sonars."""
