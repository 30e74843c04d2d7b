"""The sonars by name: `preset`."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from sim.catalogue import SONAR_PRESETS
from sim.sonar.cone.sonar import ConeSonar
from sim.sonar.cone.webots import WebotsSonar
from sim.sonar.physical.sonar import PhysicalSonar
from sim.sonar.protocol import Sonar
from sonarmap import AMIGOBOT, InputError, ring
from sonarmap.registry import Registry

__all__ = ["ARIA", "PHYSICAL", "PRESETS", "THESIS", "WEBOTS", "of", "preset"]

THESIS = ConeSonar("thesis", AMIGOBOT, scan_period_s=0.175)
"""175 ms: Rashid 2006, p. 59; 0.165 to 3.0 m: p. 56."""
ARIA = ConeSonar("aria", ring("amigobot-aria"), scan_period_s=0.100)
"""A status packet every 100 ms."""
WEBOTS = WebotsSonar("webots", ring("amigobot-aria"), scan_period_s=0.100)
PHYSICAL = PhysicalSonar("physical", replace(AMIGOBOT, range_min_m=0.10, range_max_m=5.0))
"""ARIA's ranges and the AmigoBot's symmetric ring, one sonar every 40 ms."""


class _Presets(Registry[Sonar]):
    """Sonars by name. A part is a sonar, or something that makes one without arguments."""

    def __getitem__(self, name: str) -> Sonar:
        return _sonar(name, super().__getitem__(name))

    def find(self, name: str) -> Sonar:
        """Return the sonar called `name`, see `preset`."""
        return _sonar(name, super().find(name))


PRESETS = _Presets("sonar", "sonarbed.sonar_presets", SONAR_PRESETS)


def preset(name: str) -> Sonar:
    """Return the sonar called `name`.

    Parameters
    ----------
    name : str
        A name of `PRESETS`, or ``package.module:Name`` of a sonar or of what makes one when it
        is called without arguments.

    Raises
    ------
    InputError
        If there is no such sonar (with the nearest known name), or what the name stands for is
        none.
    """
    return PRESETS.find(name)


def of(sonar: str | Sonar) -> Sonar:
    """Return the sonar of a name, or the sonar that was given; see `preset`."""
    return preset(sonar) if isinstance(sonar, str) else _checked("sonar", sonar)


def _sonar(name: str, part: Any) -> Sonar:
    """Return the sonar that a part is or makes."""
    made = part
    if callable(part):
        try:
            made = part()
        except TypeError as error:
            raise InputError(f"sonar {name!r} must be made without arguments: {error}") from error
    return _checked(f"sonar {name!r}", made, " or make one")


def _checked(what: str, sonar: Any, or_else: str = "") -> Sonar:
    # A class has what its instances have.
    has_all = all(hasattr(sonar, need) for need in ("ring", "firing", "array"))
    if isinstance(sonar, type) or not has_all:
        raise InputError(f"{what} must be a sonar{or_else}, got {sonar!r}")
    return sonar  # type: ignore[no-any-return]
