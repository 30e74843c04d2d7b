"""The exact cone: visible intervals of bearing instead of a fan of rays."""
