"""The beam of a round piston, the usual model of a sonar's transducer."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import j1

from sonarmap import InputError
from sonarmap.errors import positive

__all__ = ["Piston"]

# The nulls of the pattern are no deeper than this: real discs and echoes of 16 cycles blur them.
# Assumed.
_DEEPEST_DB = -100.0
_SPEED_MPS = 343.2


@dataclass(frozen=True, slots=True)
class Piston:
    """A disc that swings as a whole in a baffle, sends and listens.

    Parameters
    ----------
    radius_m : float
        Radius of the active disc, metres, > 0. The default, 19.2 mm, is that of the Polaroid
        600 series (38.4 mm active diameter).
    frequency_hz : float
        Frequency of the sound, hertz, > 0; 49.4 kHz: data sheet of the Polaroid 6500 module.

    Raises
    ------
    InputError
        If the disc is so small against the wavelength that it has no beam (first null beyond 90
        degrees: radius below 0.61 wavelengths), or so large that its near field is no beam
        where a sonar measures (a^2 / wavelength above 1 m).
    """

    radius_m: float = 0.0192
    frequency_hz: float = 49_400.0

    def __post_init__(self) -> None:
        positive("radius_m", self.radius_m)
        positive("frequency_hz", self.frequency_hz)
        if self.radius_m < 0.61 * self.wavelength_m:
            raise InputError(
                f"radius_m must be >= 0.61 wavelengths ({0.61 * self.wavelength_m:.3g} m), "
                f"got {self.radius_m!r}"
            )
        if self.radius_m**2 / self.wavelength_m > 1.0:
            raise InputError(
                f"radius_m must have its far field within 1 m (at most "
                f"{math.sqrt(self.wavelength_m):.3g} m), got {self.radius_m!r}"
            )

    @property
    def wavelength_m(self) -> float:
        """Wavelength at 20 degrees Celsius, metres."""
        return _SPEED_MPS / self.frequency_hz

    @property
    def null_rad(self) -> float:
        """Angle of the first null, where the main lobe ends."""
        return math.asin(0.61 * self.wavelength_m / self.radius_m)

    def level_db(self, angle_rad: ArrayLike) -> NDArray[np.float64]:
        """Return the one-way level against the axis, decibels: 20 log10 |2 J1(x) / x|.

        x is the wave number times the radius times the sine of the angle (Kinsler and Frey,
        "Fundamentals of Acoustics", the piston in a baffle). Nothing goes backwards.
        """
        angle = np.abs(np.asarray(angle_rad, float))
        x = 2 * math.pi / self.wavelength_m * self.radius_m * np.sin(angle)
        small = np.abs(x) < 1e-6
        safe = np.where(small, 1.0, x)
        amplitude = np.where(small, 1.0, np.abs(2 * j1(safe) / safe))
        floor = 10 ** (_DEEPEST_DB / 20)
        ahead = angle < math.pi / 2
        return np.where(ahead, 20 * np.log10(np.maximum(amplitude, floor)), _DEEPEST_DB)

    def reach_rad(self, two_way_db: float) -> float:
        """Return the widest angle at which the two-way level is still above -`two_way_db`."""
        angle = np.linspace(0.0, math.pi / 2, 9001)
        detectable = np.flatnonzero(2 * self.level_db(angle) > -two_way_db)
        return float(angle[detectable[-1]]) if detectable.size else 0.0
