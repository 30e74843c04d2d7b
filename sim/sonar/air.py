"""Air as sound meets it: speed and absorption by temperature and humidity."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sonarmap.errors import positive, within

__all__ = ["Air"]

_ZERO_C_K = 273.15


@dataclass(frozen=True, slots=True)
class Air:
    """Still air at normal pressure.

    Parameters
    ----------
    temperature_c : float
        Degrees Celsius, within [-20, 50], the range of ISO 9613-1.
    humidity_percent : float
        Relative humidity, within [0, 100].
    """

    temperature_c: float = 20.0
    humidity_percent: float = 50.0

    def __post_init__(self) -> None:
        within("temperature_c", self.temperature_c, -20.0, 50.0)
        within("humidity_percent", self.humidity_percent, 0.0, 100.0)

    @property
    def speed_mps(self) -> float:
        """Speed of sound in dry air of this temperature, m/s: 343.2 at 20 degrees."""
        return 331.3 * math.sqrt(1 + self.temperature_c / _ZERO_C_K)

    def absorption_db_per_m(self, frequency_hz: float) -> float:
        """Return what a pure tone loses on a metre of its path, decibels.

        Notes
        -----
        ISO 9613-1:1993, equations 3 to 5 and B.3, at 101.325 kPa. The standard covers 50 Hz to
        10 kHz; sonars at 40 to 50 kHz use the same sum of three relaxations beyond it.
        """
        positive("frequency_hz", frequency_hz)
        kelvin = self.temperature_c + _ZERO_C_K
        warmth = kelvin / 293.15
        # Molar concentration of water vapour, per cent, from the pressure of saturation.
        saturation = 10 ** (4.6151 - 6.8346 * (273.16 / kelvin) ** 1.261)
        water = self.humidity_percent * saturation
        oxygen_hz = 24 + 4.04e4 * water * (0.02 + water) / (0.391 + water)
        nitrogen_hz = warmth**-0.5 * (9 + 280 * water * math.exp(-4.170 * (warmth ** (-1 / 3) - 1)))
        relaxations = 0.01275 * math.exp(-2239.1 / kelvin) / (
            oxygen_hz + frequency_hz**2 / oxygen_hz
        ) + 0.1068 * math.exp(-3352.0 / kelvin) / (nitrogen_hz + frequency_hz**2 / nitrogen_hz)
        classical = 1.84e-11 * math.sqrt(warmth)
        loss_db: float = 8.686 * frequency_hz**2 * (classical + warmth**-2.5 * relaxations)
        return loss_db
