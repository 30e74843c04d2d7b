"""Figures 5.9 to 5.12, tables 5.1 and 5.2, question 4: goodness of maps without truth."""

from sonarbed.studies.thesis.goodness.study import run

__all__ = ["run"]
