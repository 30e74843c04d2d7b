"""Where a sensor model says the opposite of what it should: the spikes of the standard model."""

from __future__ import annotations

import numpy as np

import sonarmap as sm
from sonarmap.methods.bayes.models import probability

__all__ = ["contradictions"]


def contradictions(
    model: sm.SensorModel, reading_m: float, tolerance_m: float
) -> tuple[float, float]:
    """Return the share of a cone's area before its hill above 0.5, and of the hill below 0.5.

    The hill is what lies within the tolerance of the reading.
    """
    range_m, bearing = np.meshgrid(
        np.linspace(0.0005 * reading_m, reading_m + tolerance_m, 801),
        np.linspace(-model.half_angle_rad, model.half_angle_rad, 401),
    )
    p = probability(model, range_m, bearing, reading_m)
    hill = range_m >= reading_m - tolerance_m
    # A ring of the cone has an area that grows with its range.
    before = float((range_m * (p > 0.5 + 1e-9))[~hill].sum() / range_m[~hill].sum())
    return before, float((range_m * (p < 0.5 - 1e-9))[hill].sum() / range_m[hill].sum())
