"""The sonars that can be named: `preset`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from sim.sonar.cone.sonar import ConeSonar
from sim.sonar.cone.webots import WebotsSonar
from sim.sonar.physical.sonar import PhysicalSonar
from sim.sonar.protocol import Sonar
from sonarmap import AMIGOBOT, InputError, ring
from sonarmap.errors import did_you_mean

__all__ = ["PRESETS", "preset"]

# `physical`: ARIA's ranges and the AmigoBot's symmetric ring, one sonar every 40 ms.
# `thesis`: 175 ms, Rashid 2006 p. 59; 0.165 to 3.0 m, p. 56. `aria`: a status packet every 100 ms.
PRESETS: Mapping[str, Sonar] = MappingProxyType(
    {
        sonar.name: sonar
        for sonar in (
            ConeSonar("thesis", AMIGOBOT, scan_period_s=0.175),
            ConeSonar("aria", ring("amigobot-aria"), scan_period_s=0.100),
            WebotsSonar("webots", ring("amigobot-aria"), scan_period_s=0.100),
            PhysicalSonar("physical", replace(AMIGOBOT, range_min_m=0.10, range_max_m=5.0)),
        )
    }
)


def preset(name: str) -> Sonar:
    """Return the preset called `name`, or raise `InputError` with the nearest known name."""
    try:
        return PRESETS[name]
    except KeyError:
        raise InputError(f"sonar {name!r} is unknown{did_you_mean(name, PRESETS)}") from None
