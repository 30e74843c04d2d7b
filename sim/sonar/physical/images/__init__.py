"""The physical sonar where the faces are known: sounds by image sources, counted, not found."""
