"""`ImageSetup`: what listening by images needs to know of a room and of the sonars in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.sonar.physical.detection import Reading
from sim.sonar.physical.images.limits import ImageLimits
from sim.sonar.physical.images.room import Scene, scene_of
from sim.sonar.physical.levels import Acoustics
from sim.sonar.physical.spread import Transducers, TransducerSpread
from sim.sonar.physical.surfaces import surface_table
from worlds import Faces, World

__all__ = ["CompiledImages", "ImageSetup"]


class ImageSetup(NamedTuple):
    """What `sim.sonar.physical.images.scan.listen_images` needs, the same for a whole drive.

    Parameters
    ----------
    scene : Scene
        The room.
    surfaces, acoustics
        See `sim.sonar.physical.tracing.advance_tracing`.
    limits : ImageLimits
        What is looked for.
    monostatic : bool
        Whether each sonar receives its own sound only.
    transducers : Transducers
        Of the ring.
    reading : Reading
        What is read of what is detected.
    """

    scene: Scene
    surfaces: NDArray[np.float64]
    acoustics: Acoustics
    limits: ImageLimits
    monostatic: bool
    transducers: Transducers
    reading: Reading


@dataclass(frozen=True, slots=True, eq=False)
class CompiledImages:
    """A physical sonar as numbers, for compiled code that listens by images.

    Parameters
    ----------
    sonars : int
        How many its ring has.
    acoustics, limits, reading
        See `ImageSetup`.
    spread : TransducerSpread
        How much its transducers differ.
    """

    sonars: int
    acoustics: Acoustics
    limits: ImageLimits
    reading: Reading
    spread: TransducerSpread

    def drawn(self, faces: Faces, world: World, rng: np.random.Generator) -> ImageSetup:
        """Return the setup of a drive in a room, with transducers as `PhysicalSonar.array` has."""
        return self.setup(faces, world, self.spread.drawn(self.sonars, rng))

    def setup(
        self, faces: Faces, world: World, transducers: Transducers, *, monostatic: bool = False
    ) -> ImageSetup:
        """Return the setup of some transducers among faces, made of what a world is made of."""
        return ImageSetup(
            scene_of(faces, world),
            surface_table(world),
            self.acoustics,
            self.limits,
            monostatic,
            transducers,
            self.reading,
        )
