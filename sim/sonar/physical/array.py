"""The physical sonars of a drive: the first sound over the threshold counts, whoever sent it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.engines.protocol import RayCaster
from sim.sonar.physical import columns as t
from sim.sonar.physical.detection import Reading, detect, readings
from sim.sonar.physical.echoes import confirmed, find_sounds
from sim.sonar.physical.images.scan import listen_images
from sim.sonar.physical.images.setup import ImageSetup
from sim.sonar.physical.interferer import Interferer
from sim.sonar.physical.levels import Acoustics, mirror_echo_db
from sim.sonar.physical.piston import Piston
from sim.sonar.physical.spread import Transducers
from sim.sonar.physical.surfaces import surface_table
from sim.sonar.physical.tracing import Tracing, TracingLimits, advance_tracing, begin_tracing
from sim.sonar.protocol import Echoes
from sonarmap import LogTruth
from worlds import Faces, World

__all__ = ["ArrayModel", "ImageArray", "PhysicalArray", "known_faces"]


@dataclass(frozen=True, slots=True, eq=False)
class ArrayModel:
    """What an array computes with, derived from a `sim.PhysicalSonar`.

    Parameters
    ----------
    piston, interferers
        Of the sonar.
    reading : Reading
        What is read of what is detected.
    acoustics, limits
        What the compiled steps know of levels and of tracing.
    bearing_rad, ray_reach_m : ndarray, shape (rays,)
        The rays of a fan, and how far each is traced.
    """

    piston: Piston
    interferers: tuple[Interferer, ...]
    reading: Reading
    acoustics: Acoustics
    limits: TracingLimits
    bearing_rad: NDArray[np.float64]
    ray_reach_m: NDArray[np.float64]


class PhysicalArray:
    """The sonars of one drive, with the sounds that are under way.

    Parameters
    ----------
    model : ArrayModel
        What they are like.
    rays : RayCaster
        Where the surfaces are.
    world : World
        What they are made of.
    rng : numpy.random.Generator
        Draws one number a firing.
    transducers : Transducers
        Of the ring.
    monostatic : bool
        Whether each sonar receives its own sound only.
    """

    def __init__(
        self,
        model: ArrayModel,
        rays: RayCaster,
        world: World,
        rng: np.random.Generator,
        transducers: Transducers,
        *,
        monostatic: bool = False,
    ) -> None:
        self._model, self._rays, self._rng = model, rays, rng
        self._monostatic, self._transducers = monostatic, transducers
        self._surfaces = surface_table(world)
        self._fired: list[tuple[float, ...]] = []
        self._sounds = np.empty((0, t.SOUND_COLUMNS))

    def fire(
        self,
        time_s: float,
        sonars: tuple[int, ...],
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
    ) -> None:
        """Let some sonars fire at once, see `sim.sonar.protocol.SonarArray`."""
        tracing = self._trace(np.array(sonars, np.int64), sensor_xy_m, axis_rad)
        outside = _from_interferers(
            self._model, self._rays, self._transducers, time_s, sonars, sensor_xy_m, axis_rad
        )
        self._sounds = np.concatenate([self._sounds, self._echoes(tracing, time_s), *outside])
        self._fired += [
            (time_s, sonar, tracing.axis_range_m[sonar], tracing.cone_range_m[sonar])
            for sonar in sonars
        ]

    def detect(self) -> Echoes:
        """Return what the sonars detected that fired since the last call, in their order."""
        model, fired = self._model, np.array(self._fired)
        self._fired = []
        # Later firings may still detect what was sent a moment ago.
        detections, self._sounds = detect(fired, self._sounds, model.acoustics)
        draws = self._rng.normal(0.0, 1.0, len(fired))
        reading_m = readings(detections, draws, self._surfaces, model.reading)
        return Echoes(
            range_m=reading_m,
            axis_range_m=fired[:, t.FIRED_AXIS],
            cone_range_m=fired[:, t.FIRED_CONE],
            cause=detections.cause,
            surface=detections.surface,
            incidence_rad=detections.incidence_rad,
            bounces=detections.bounces,
            source=detections.source,
            level_db=detections.level_db,
        )

    def _trace(
        self,
        sonars: NDArray[np.int64],
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
    ) -> Tracing:
        """Trace the faces around some sonars."""
        model = self._model
        tracing: Tracing = begin_tracing(
            sonars,
            sensor_xy_m,
            axis_rad,
            *self._transducers,
            model.bearing_rad,
            model.ray_reach_m,
        )
        while len(tracing.rays):
            tracing = advance_tracing(
                tracing, *self._cast(tracing.rays), self._surfaces, model.limits, model.acoustics
            )
        return tracing

    def _echoes(self, tracing: Tracing, time_s: float) -> NDArray[np.float64]:
        """Return the sounds of a firing whose paths are free."""
        sounds: NDArray[np.float64]
        sounds, checks = find_sounds(
            tracing,
            time_s,
            self._monostatic,
            self._surfaces,
            self._model.limits,
            self._model.acoustics,
        )
        if len(checks):
            met_m, _, _ = self._cast(checks)
            sounds = confirmed(sounds, checks, met_m)
        return sounds

    def _cast(
        self, rays: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int32]]:
        """Return (distance, normal, surface) of what rays meet."""
        hits = self._rays.cast(
            rays[:, t.RAY_X : t.RAY_Y + 1], rays[:, t.RAY_DX : t.RAY_DY + 1], rays[:, t.RAY_REACH]
        )
        return hits.distance_m, np.ascontiguousarray(hits.normal_xy), hits.surface


class ImageArray:
    """The sonars of one drive in a room whose faces are known, by image sources.

    Firings wait until `detect`, which computes all of them in one compiled call.

    Parameters
    ----------
    setup : ImageSetup
        The sonars and the room.
    model, rays, rng
        As of `PhysicalArray`; only the sound of interferers is looked for by rays.
    """

    def __init__(
        self, setup: ImageSetup, model: ArrayModel, rays: RayCaster, rng: np.random.Generator
    ) -> None:
        # A plain tuple: numba takes it over from Python in less time than a named one.
        self._setup, self._transducers = tuple(setup), setup.transducers
        self._model, self._rays, self._rng = model, rays, rng
        self._sounds = np.empty((0, t.SOUND_COLUMNS))
        self._outside: list[NDArray[np.float64]] = []
        self._forget()

    def _forget(self) -> None:
        self._times_s: list[float] = []
        self._sonars: list[int] = []
        self._start = [0]
        self._xy_m: list[NDArray[np.float64]] = []
        self._axis_rad: list[NDArray[np.float64]] = []

    def fire(
        self,
        time_s: float,
        sonars: tuple[int, ...],
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
    ) -> None:
        """Let some sonars fire at once, see `sim.sonar.protocol.SonarArray`."""
        self._times_s.append(time_s)
        self._sonars += sonars
        self._start.append(len(self._sonars))
        self._xy_m.append(sensor_xy_m.copy())
        self._axis_rad.append(axis_rad.copy())
        if self._model.interferers:
            self._outside += _from_interferers(
                self._model, self._rays, self._transducers, time_s, sonars, sensor_xy_m, axis_rad
            )

    def detect(self) -> Echoes:
        """Return what the sonars detected that fired since the last call, in their order."""
        reading_m, fired, detections, self._sounds = listen_images(
            self._setup,
            np.array(self._times_s, float),
            np.array(self._sonars),
            np.array(self._start),
            np.array(self._xy_m, float),
            np.array(self._axis_rad, float),
            np.concatenate([self._sounds, *self._outside]) if self._outside else self._sounds,
            self._rng.normal(0.0, 1.0, len(self._sonars)),
        )
        self._outside = []
        self._forget()
        return Echoes(
            range_m=reading_m,
            axis_range_m=fired[:, t.FIRED_AXIS],
            cone_range_m=fired[:, t.FIRED_CONE],
            cause=detections.cause,
            surface=detections.surface,
            incidence_rad=detections.incidence_rad,
            bounces=detections.bounces,
            source=detections.source,
            level_db=detections.level_db,
        )


def known_faces(rays: RayCaster) -> Faces | None:
    """Return the faces that a ray caster's rays would meet; None if it does not know them."""
    faces = rays if isinstance(rays, Faces) else getattr(rays, "faces", None)
    return faces if isinstance(faces, Faces) else None


def _from_interferers(
    model: ArrayModel,
    rays: RayCaster,
    transducers: Transducers,
    time_s: float,
    sonars: tuple[int, ...],
    sensor_xy_m: NDArray[np.float64],
    axis_rad: NDArray[np.float64],
) -> list[NDArray[np.float64]]:
    """Return the interferers' pulses that may reach, straight, the sonars that listen now."""
    found = []
    acoustics = model.acoustics
    listeners = np.array(sonars)
    for interferer in model.interferers:
        offset = np.array([interferer.x_m, interferer.y_m]) - sensor_xy_m[listeners]
        path_m = np.maximum(np.hypot(offset[:, 0], offset[:, 1]), 1e-6)
        hits = rays.cast(sensor_xy_m[listeners], offset / path_m[:, None], path_m)
        bearing = np.arctan2(offset[:, 1], offset[:, 0]) - axis_rad[listeners]
        bearing -= transducers.lean_rad[listeners]
        received_db = model.piston.level_db(np.remainder(bearing + np.pi, 2 * np.pi) - np.pi)
        received_db = received_db + transducers.gain_db[listeners]
        for k in np.flatnonzero(hits.surface < 0):
            travel_s = path_m[k] / acoustics.speed_mps
            pulses_s = interferer.pulses_s(
                time_s - travel_s, time_s - travel_s + acoustics.window_s
            )
            sounds = np.zeros((pulses_s.size, t.SOUND_COLUMNS))
            sounds[:, t.SOUND_SENT] = pulses_s
            sounds[:, t.SOUND_SOURCE] = LogTruth.OUTSIDE_SOURCE
            sounds[:, t.SOUND_LISTENER], sounds[:, t.SOUND_PATH] = listeners[k], path_m[k]
            sounds[:, t.SOUND_LEVEL] = (
                mirror_echo_db(acoustics, path_m[k]) + received_db[k] + interferer.level_db
            )
            sounds[:, t.SOUND_SURFACE], sounds[:, t.SOUND_INCIDENCE] = -1, np.nan
            found.append(sounds)
    return found
