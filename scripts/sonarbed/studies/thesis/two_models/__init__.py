"""Figure 5.8 and question 5: the standard and the parameterized model compared."""

from sonarbed.studies.thesis.two_models.study import run

__all__ = ["run"]
