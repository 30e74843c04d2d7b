"""The physical sonar: tracing of image sources, echoes, detection."""
