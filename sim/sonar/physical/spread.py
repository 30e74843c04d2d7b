"""`TransducerSpread`: how much a ring's transducers differ; `Transducers`: those of a drive."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import non_negative, whole

__all__ = ["TransducerSpread", "Transducers"]

# Draws farther out are set to so many standard deviations: makers sort out what is far off.
_MOST_STD = 2.0


class Transducers(NamedTuple):
    """What the transducers of a ring are like.

    Parameters
    ----------
    gain_db : ndarray, shape (k,)
        How much more sensitive each is than the nominal one, decibels, one way.
    lean_rad : ndarray, shape (k,)
        How far its beam leans to the left of its axis, radians.
    """

    gain_db: NDArray[np.float64]
    lean_rad: NDArray[np.float64]

    @classmethod
    def alike(cls, count: int) -> Transducers:
        """Return nominal ones."""
        return cls(np.zeros(count), np.zeros(count))


@dataclass(frozen=True, slots=True)
class TransducerSpread:
    """How much the transducers of a ring differ, in sensitivity and in direction.

    Parameters
    ----------
    sensitivity_std_db : float
        Standard deviation of a transducer's sensitivity against the nominal one, decibels, one
        way, >= 0: an own echo differs by twice that. Draws are cut at two of them. Default 1 dB,
        assumed: data sheets of such transducers allow 3 dB.
    direction_std_rad : float
        Standard deviation of the angle between the beam and the axis that the ring states,
        radians, >= 0, cut likewise. Default 1 degree, assumed.
    seed : int, optional
        Of the transducers, >= 0: the same ones in every drive. By default every drive draws its
        own, from its own seed: another robot of the same kind.
    """

    sensitivity_std_db: float = 1.0
    direction_std_rad: float = math.radians(1.0)
    seed: int | None = None

    def __post_init__(self) -> None:
        non_negative("sensitivity_std_db", self.sensitivity_std_db)
        non_negative("direction_std_rad", self.direction_std_rad)
        if self.seed is not None:
            object.__setattr__(self, "seed", whole("seed", self.seed, least=0))

    @property
    def most_db(self) -> float:
        """Most that a transducer is louder than the nominal one, decibels, one way."""
        return _MOST_STD * self.sensitivity_std_db

    @property
    def most_rad(self) -> float:
        """Most that a beam leans away from the stated axis, radians."""
        return _MOST_STD * self.direction_std_rad

    def drawn(self, count: int, rng: np.random.Generator) -> Transducers:
        """Return the transducers of a drive.

        Parameters
        ----------
        count : int
            How many.
        rng : numpy.random.Generator
            Of the drive; it draws the same numbers afterwards as without.
        """
        own = rng.spawn(1)[0] if self.seed is None else np.random.default_rng(self.seed)
        draws = np.clip(own.normal(size=(2, count)), -_MOST_STD, _MOST_STD)
        return Transducers(self.sensitivity_std_db * draws[0], self.direction_std_rad * draws[1])
