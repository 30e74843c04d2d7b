"""What the sonars of a drive hear: the first sound over the threshold, whoever sent it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sim.engines.protocol import RayCaster
from sim.sonar.physical import columns as t
from sim.sonar.physical.detection import hear, readings
from sim.sonar.physical.echoes import confirmed, find_sounds
from sim.sonar.physical.levels import way_db
from sim.sonar.physical.tracing import Survey, advance, begin
from sim.sonar.protocol import Echoes
from sonarmap import LogTruth
from worlds import World

if TYPE_CHECKING:
    from sim.sonar.physical.sonar import PhysicalSonar

__all__ = ["PhysicalEars"]


class PhysicalEars:
    """The sonars of one drive, with the sounds that are under way."""

    def __init__(
        self,
        sonar: PhysicalSonar,
        rays: RayCaster,
        world: World,
        rng: np.random.Generator,
        *,
        alone: bool = False,
    ) -> None:
        self._sonar, self._rays, self._rng = sonar, rays, rng
        self._alone = alone
        self._surfaces = _surface_table(world)
        self._fired: list[tuple[float, ...]] = []
        self._sounds = np.empty((0, t.SOUND_COLUMNS))

    def fire(
        self,
        time_s: float,
        sonars: tuple[int, ...],
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
    ) -> None:
        """Let some sonars fire at once, see `sim.sonar.protocol.Ears`."""
        survey = self._survey(np.array(sonars, np.int64), sensor_xy_m, axis_rad)
        outside = self._from_beacons(time_s, sonars, sensor_xy_m, axis_rad)
        self._sounds = np.concatenate([self._sounds, self._echoes(survey, time_s), *outside])
        self._fired += [
            (time_s, sonar, survey.axis_range_m[sonar], survey.cone_range_m[sonar])
            for sonar in sonars
        ]

    def hear(self) -> Echoes:
        """Return what the sonars heard that fired since the last call, in their order."""
        sonar, fired = self._sonar, np.array(self._fired)
        self._fired = []
        # Later firings may still hear what was sent a moment ago.
        heard, self._sounds = hear(fired, self._sounds, sonar.acoustics)
        receiver, ring = sonar.receiver, sonar.ring
        draws = self._rng.normal(0.0, 1.0, len(fired))
        reading_m = readings(
            heard,
            draws,
            self._surfaces,
            receiver.noise_std_m,
            receiver.weak_noise_std_m,
            receiver.quantum_m,
            ring.range_min_m,
            ring.range_max_m,
        )
        return Echoes(
            range_m=reading_m,
            axis_range_m=fired[:, t.FIRED_AXIS],
            cone_range_m=fired[:, t.FIRED_CONE],
            cause=heard.cause,
            surface=heard.surface,
            incidence_rad=heard.incidence_rad,
            bounces=heard.bounces,
            source=heard.source,
            level_db=heard.level_db,
        )

    def _survey(
        self,
        sonars: NDArray[np.int64],
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
    ) -> Survey:
        """Return the faces around some sonars."""
        sonar = self._sonar
        survey: Survey = begin(sonars, sensor_xy_m, axis_rad, sonar.bearing_rad, sonar.ray_reach_m)
        while len(survey.rays):
            survey = advance(
                survey, *self._cast(survey.rays), self._surfaces, sonar.rules, sonar.acoustics
            )
        return survey

    def _echoes(self, survey: Survey, time_s: float) -> NDArray[np.float64]:
        """Return the sounds of a firing whose ways are free."""
        sounds: NDArray[np.float64]
        sounds, checks = find_sounds(
            survey, time_s, self._alone, self._surfaces, self._sonar.rules, self._sonar.acoustics
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

    def _from_beacons(
        self,
        time_s: float,
        sonars: tuple[int, ...],
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
    ) -> list[NDArray[np.float64]]:
        """Return the beacons' pulses that may reach, straight, the sonars that listen now."""
        sonar, found = self._sonar, []
        listeners = np.array(sonars)
        for beacon in sonar.beacons:
            offset = np.array([beacon.x_m, beacon.y_m]) - sensor_xy_m[listeners]
            way_m = np.maximum(np.hypot(offset[:, 0], offset[:, 1]), 1e-6)
            hits = self._rays.cast(sensor_xy_m[listeners], offset / way_m[:, None], way_m)
            bearing = np.arctan2(offset[:, 1], offset[:, 0]) - axis_rad[listeners]
            received_db = sonar.piston.level_db(np.remainder(bearing + np.pi, 2 * np.pi) - np.pi)
            for k in np.flatnonzero(hits.surface < 0):
                travel_s = way_m[k] / sonar.air.speed_mps
                pulses_s = beacon.pulses_s(time_s - travel_s, time_s - travel_s + sonar.window_s)
                sounds = np.zeros((pulses_s.size, t.SOUND_COLUMNS))
                sounds[:, t.SOUND_SENT] = pulses_s
                sounds[:, t.SOUND_SOURCE] = LogTruth.OUTSIDE_SOURCE
                sounds[:, t.SOUND_LISTENER], sounds[:, t.SOUND_WAY] = listeners[k], way_m[k]
                sounds[:, t.SOUND_LEVEL] = (
                    way_db(sonar.acoustics, way_m[k]) + received_db[k] + beacon.level_db
                )
                sounds[:, t.SOUND_SURFACE], sounds[:, t.SOUND_INCIDENCE] = -1, np.nan
                found.append(sounds)
        return found


def _surface_table(world: World) -> NDArray[np.float64]:
    """Return what the surfaces are like; surface -1, none, takes the last row."""
    table = np.zeros((len(world.roughness_m) + 1, t.SURFACE_COLUMNS))
    table[:-1, t.SURFACE_RADIUS] = world.radius_m
    table[:-1, t.SURFACE_MIRROR] = 20 * np.log10(np.maximum(world.reflectivity, 1e-10))
    table[:-1, t.SURFACE_FLOOR] = world.diffuse_floor_db
    table[:-1, t.SURFACE_ROUGHNESS] = world.roughness_m
    return table
