"""Figures 6.2, 6.4 and 6.6: readings as data points, the plot S, the estimated walls ES."""

from sonarbed.studies.thesis.data_points.study import run

__all__ = ["run"]
