"""Figure 6.12: from how far an opening is still seen, and the equation for it."""

from sonarbed.studies.thesis.openings.study import run

__all__ = ["run"]
