"""The sonars that can be named: `preset`."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from sim.acoustics import Sonar
from sim.cone import ConeSonar
from sonarmap import AMIGOBOT, InputError, ring
from sonarmap.errors import did_you_mean

__all__ = ["PRESETS", "preset"]

# `thesis`: 175 ms, Rashid 2006 p. 59; 0.165 to 3.0 m, p. 56. `aria`: a status packet every 100 ms.
PRESETS: Mapping[str, Sonar] = MappingProxyType(
    {
        sonar.name: sonar
        for sonar in (
            ConeSonar("thesis", AMIGOBOT, scan_period_s=0.175),
            ConeSonar("aria", ring("amigobot-aria"), scan_period_s=0.100),
        )
    }
)


def preset(name: str) -> Sonar:
    """Return the preset called `name`, or raise `InputError` with the nearest known name."""
    try:
        return PRESETS[name]
    except KeyError:
        raise InputError(f"sonar {name!r} is unknown{did_you_mean(name, PRESETS)}") from None
