"""Poses by odometry, refined by the walls that a log's echoes agree on."""
