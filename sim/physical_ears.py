"""What the sonars of a drive hear: the first sound over the threshold, whoever sent it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sim import echoing as e
from sim.acoustics import Echoes, cause_of
from sim.engine import RayCaster
from sim.sound_fans import Fans, no_sounds
from sonarmap import Cause, LogTruth
from worlds import World

if TYPE_CHECKING:
    from sim.physical import PhysicalSonar

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
        # One entry more: surface -1, none, is the last.
        self._roughness_m = np.append(world.roughness_m, 0.0)
        with np.errstate(divide="ignore"):
            reflect_db = 20 * np.log10(np.maximum(world.reflectivity, 1e-10))
        self._surfaces = (
            np.append(world.radius_m, 0.0),
            np.append(reflect_db, 0.0),
            np.append(world.diffuse_floor_db, 0.0),
        )
        self._fired: list[tuple[float, int, float, float]] = []
        self._sounds = no_sounds()

    def fire(
        self,
        time_s: float,
        sonars: tuple[int, ...],
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
    ) -> None:
        """Let some sonars fire at once, see `sim.acoustics.Ears`."""
        fans = Fans(
            self._sonar,
            self._rays,
            self._surfaces,
            sonars,
            sensor_xy_m,
            axis_rad,
            alone=self._alone,
        )
        sounds = fans.sounds(time_s)
        axis_range_m, cone_range_m = fans.truth()
        outside = self._from_beacons(time_s, np.array(sonars), sensor_xy_m, axis_rad)
        self._sounds = np.concatenate([self._sounds, sounds, *outside])
        self._fired += [
            (time_s, sonar, axis_range_m[k], cone_range_m[k]) for k, sonar in enumerate(sonars)
        ]

    def hear(self) -> Echoes:
        """Return what the sonars heard that fired since the last call, in their order."""
        sonar, receiver, sounds = self._sonar, self._sonar.receiver, self._sounds
        fired_s, number, axis_range_m, cone_range_m = np.array(self._fired).T
        number = number.astype(np.int64)
        heard, time_s, over_db = e.first_crossings(
            fired_s,
            number,
            sonar.window_s,
            sounds["sent_s"],
            sounds["source"],
            sounds["listener"],
            sounds["way_m"],
            sounds["level_db"],
            sonar.sound_life_s,
            sonar.air_table,
            receiver.pulse_s,
            receiver.blanking_s,
        )
        silent = heard < 0
        # What nobody heard takes a line of its own, the last.
        best = np.append(sounds, no_sounds(1))[heard]
        cause = cause_of(
            np.where(silent, np.inf, best["way_m"] / 2), best["bounces"], axis_range_m, cone_range_m
        )
        others = (best["source"] != number) | (best["sent_s"] != fired_s)
        cause[others & ~silent] = Cause.CROSSTALK
        range_m = sonar.assumed_air.speed_mps * time_s / 2
        self._fired = []
        # Later firings may still hear what was sent a moment ago.
        self._sounds = sounds[sounds["sent_s"] + sonar.sound_life_s > fired_s[-1]]
        return Echoes(
            range_m=self._measured(range_m, over_db, self._roughness_m[best["surface"]]),
            axis_range_m=axis_range_m,
            cone_range_m=cone_range_m,
            cause=cause,
            surface=best["surface"],
            incidence_rad=best["incidence_rad"],
            bounces=best["bounces"],
            source=best["source"],
            level_db=over_db,
        )

    def _from_beacons(
        self,
        time_s: float,
        sonars: NDArray[np.int64],
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
    ) -> list[NDArray[np.void]]:
        """Return the beacons' pulses that may reach, straight, the sonars that listen now."""
        sonar, found = self._sonar, []
        for beacon in sonar.beacons:
            offset = np.array([beacon.x_m, beacon.y_m]) - sensor_xy_m[sonars]
            way_m = np.maximum(np.hypot(offset[:, 0], offset[:, 1]), 1e-6)
            hits = self._rays.cast(sensor_xy_m[sonars], offset / way_m[:, None], way_m)
            bearing = np.arctan2(offset[:, 1], offset[:, 0]) - axis_rad[sonars]
            received_db = sonar.piston.level_db(np.remainder(bearing + np.pi, 2 * np.pi) - np.pi)
            for k in np.flatnonzero(hits.surface < 0):
                travel_s = way_m[k] / sonar.air.speed_mps
                pulses_s = beacon.pulses_s(time_s - travel_s, time_s - travel_s + sonar.window_s)
                sounds = no_sounds(pulses_s.size)
                sounds["sent_s"], sounds["source"] = pulses_s, LogTruth.OUTSIDE_SOURCE
                sounds["listener"], sounds["way_m"] = sonars[k], way_m[k]
                sounds["level_db"] = (
                    e.way_db(sonar.air_table, way_m[k]) + received_db[k] + beacon.level_db
                )
                found.append(sounds)
        return found

    def _measured(
        self,
        range_m: NDArray[np.float64],
        over_db: NDArray[np.float64],
        roughness_m: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        receiver, ring = self._sonar.receiver, self._sonar.ring
        jitter_m = receiver.weak_noise_std_m * 10 ** (-np.nan_to_num(over_db) / 20)
        std_m = np.sqrt(receiver.noise_std_m**2 + jitter_m**2 + roughness_m**2)
        reading = range_m + self._rng.normal(0.0, 1.0, range_m.size) * std_m
        if receiver.quantum_m > 0:
            reading = np.round(reading / receiver.quantum_m) * receiver.quantum_m
        # Noise alone must not turn an echo at the very end of the range into silence.
        reading = np.where(np.isfinite(range_m), np.minimum(reading, ring.range_max_m), np.inf)
        return np.where(reading < ring.range_min_m, -np.inf, reading)
