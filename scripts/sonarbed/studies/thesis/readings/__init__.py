"""Question 2: which readings HSR mends, which it spoils, and where."""

from sonarbed.studies.thesis.readings.study import run

__all__ = ["run"]
