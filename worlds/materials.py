"""`Material`: what a surface does to the sound of a 50 kHz sonar, with presets by name."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from sonarmap.errors import InputError, did_you_mean, non_negative, within

__all__ = ["MATERIALS", "Material", "find_material"]


@dataclass(frozen=True, slots=True)
class Material:
    """How a surface sends sound back.

    Parameters
    ----------
    name : str
        Name of the material.
    critical_incidence_rad : float
        Angle from the surface normal beyond which sound is mirrored away and no longer
        returns to the sonar, radians, in (0, pi/2].
    reflectivity : float
        Share of the amplitude that is not absorbed, in [0, 1].
    roughness_m : float
        Height of the surface's irregularities in metres, >= 0. By Rayleigh's criterion a
        surface is a mirror below an eighth of the wavelength: 0.87 mm at 49.4 kHz.
    diffuse_floor_db : float
        Level of what the surface scatters straight back, seen head-on, against what it mirrors,
        decibels, in [-100, 0]. The default is a mirror's.
    """

    name: str
    critical_incidence_rad: float
    reflectivity: float
    roughness_m: float
    diffuse_floor_db: float = -60.0

    def __post_init__(self) -> None:
        if not 0 < self.critical_incidence_rad <= math.pi / 2:
            raise InputError(
                f"critical_incidence_rad must be within (0, pi/2], "
                f"got {self.critical_incidence_rad!r}"
            )
        within("reflectivity", self.reflectivity, 0.0, 1.0)
        non_negative("roughness_m", self.roughness_m)
        within("diffuse_floor_db", self.diffuse_floor_db, -100.0, 0.0)


def _preset(
    name: str, *, critical_deg: float, loss_db: float, roughness_mm: float, floor_db: float
) -> tuple[str, Material]:
    reflectivity = 10 ** (-loss_db / 20)  # a loss in dB is 20 log10 of the amplitude's share
    material = Material(
        name, math.radians(critical_deg), reflectivity, roughness_mm / 1000, floor_db
    )
    return name, material


# No table of materials at 50 kHz is known that could be quoted whole. The critical angles and
# losses are the middle of the ranges that simulators and papers use as fixed presets; they are
# hypotheses until calibrated, since the angle also depends on the beam and the receiver's gain
# (Cao and Borenstein 2002 saw a wall up to 42 degrees with side lobes). Every roughness is
# assumed; what matters is its side of Rayleigh's 0.87 mm. The diffuse floors are hypotheses of the
# same kind: none to -50 dB for mirrors, -45 smooth building materials, -40 boards, -20 to -25
# rough walls, -15 to -20 scatterers; an absorber's floor, "low", is assumed.
MATERIALS: Mapping[str, Material] = MappingProxyType(
    dict(
        [
            # Mirrors: 15-22 degrees, 0-0.5 dB. Webots cuts every surface at 22.5 degrees.
            _preset("glass", critical_deg=18, loss_db=0.2, roughness_mm=0.01, floor_db=-55),
            _preset("metal", critical_deg=18, loss_db=0.2, roughness_mm=0.01, floor_db=-55),
            _preset("whiteboard", critical_deg=19, loss_db=0.4, roughness_mm=0.02, floor_db=-50),
            # Smooth building materials: 18-25 degrees, 0.5-1 dB.
            _preset("drywall", critical_deg=22, loss_db=0.75, roughness_mm=0.1, floor_db=-45),
            _preset("wood", critical_deg=22, loss_db=0.75, roughness_mm=0.15, floor_db=-45),
            # Boards: 20-30 degrees, 1-2 dB; a poster's white card stands at the smooth end.
            _preset(
                "smooth-cardboard", critical_deg=20, loss_db=1.0, roughness_mm=0.05, floor_db=-42
            ),
            _preset("cardboard", critical_deg=25, loss_db=1.5, roughness_mm=0.3, floor_db=-40),
            # Rough walls: 45-65 degrees, 1-2 dB; joints and stipple exceed 0.87 mm.
            _preset("plaster", critical_deg=50, loss_db=1.5, roughness_mm=2.0, floor_db=-23),
            _preset("brick", critical_deg=55, loss_db=1.5, roughness_mm=3.0, floor_db=-20),
            # Scatterers: 60-75 degrees, 3-6 dB.
            _preset("carpet", critical_deg=65, loss_db=5.0, roughness_mm=5.0, floor_db=-18),
            _preset("books", critical_deg=70, loss_db=4.0, roughness_mm=10.0, floor_db=-15),
            # Absorbers: 10-20 dB, often missed beyond 1-2 m; their angles are assumed.
            _preset("curtain", critical_deg=45, loss_db=12.0, roughness_mm=5.0, floor_db=-30),
            _preset("foam", critical_deg=45, loss_db=16.0, roughness_mm=2.0, floor_db=-35),
        ]
    )
)


def find_material(
    material: str | Material, own: Mapping[str, Material] = MappingProxyType({})
) -> Material:
    """Return a material by its name, one of a room's own before a preset; or the material given.

    Raises
    ------
    InputError
        If there is no such material; the message starts with ``material:``.
    """
    if isinstance(material, Material):
        return material
    known = {**MATERIALS, **own}
    if not isinstance(material, str) or material not in known:
        hint = did_you_mean(str(material), known)
        raise InputError(f"material: unknown material {material!r}{hint}")
    return known[material]
