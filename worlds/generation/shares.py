"""Materials by distribution: ``"drywall:5,glass:1"`` is glass once in six."""

from __future__ import annotations

from functools import cache

from sonarmap.errors import InputError, did_you_mean
from worlds.materials import MATERIALS

__all__ = ["material_shares"]


@cache
def material_shares(name: str, text: str) -> dict[str, float]:
    """Return the share of each material that a text gives, as ``material:share,material:share``.

    A material alone has the share 1. `name` is what messages call the text.

    Raises
    ------
    InputError
        If a material is unknown or there twice, a share is no number >= 0, or none is > 0.
    """
    shares: dict[str, float] = {}
    for part in text.split(","):
        material, colon, share = (word.strip() for word in part.partition(":"))
        if material not in MATERIALS:
            raise InputError(
                f"{name}: unknown material {material!r}{did_you_mean(material, MATERIALS)}"
            )
        if material in shares:
            raise InputError(f"{name}: {material!r} is there twice")
        try:
            shares[material] = float(share) if colon else 1.0
        except ValueError:
            raise InputError(f"{name}: must be material:share,..., got {part!r}") from None
        if not 0 <= shares[material] <= 1e6:
            raise InputError(f"{name}: a share must be within [0, 1e6], got {share}")
    if not sum(shares.values()) > 0:
        raise InputError(f"{name}: some share must be > 0, got {text!r}")
    return shares
