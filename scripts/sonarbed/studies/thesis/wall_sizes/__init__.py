"""Figures 6.15 and 6.16, table 6.1, questions 1 and 3: the sizes of estimated walls."""

from sonarbed.studies.thesis.wall_sizes.study import run

__all__ = ["run"]
