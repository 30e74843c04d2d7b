"""`sonarbed worlds materials`: what surfaces do to sound."""

from __future__ import annotations

from sonarbed.options import Json

__all__ = ["materials"]


def materials(as_json: Json = False) -> None:
    """List the materials of walls and things with their numbers.

    Example:

      sonarbed worlds materials
    """
    import math

    from sonarbed.console import print_json, print_table
    from worlds import MATERIALS

    if as_json:
        print_json(
            {
                name: {
                    "critical_incidence_deg": round(math.degrees(each.critical_incidence_rad), 9),
                    "reflectivity": each.reflectivity,
                    "roughness_mm": round(each.roughness_m * 1000, 9),
                    "diffuse_floor_db": each.diffuse_floor_db,
                }
                for name, each in MATERIALS.items()
            }
        )
        return
    print_table(
        "Materials, at 50 kHz (hypotheses: see worlds/materials.py)",
        ["name", "mirrors beyond", "loss", "reflectivity", "roughness", "diffuse floor"],
        [
            [
                name,
                f"{math.degrees(each.critical_incidence_rad):.0f}°",
                f"{-20 * math.log10(each.reflectivity):.2g} dB",
                f"{each.reflectivity:.2f}",
                f"{each.roughness_m * 1000:g} mm",
                f"{each.diffuse_floor_db:g} dB",
            ]
            for name, each in MATERIALS.items()
        ],
    )
