"""The physical sonar: beam, mirror echoes, scattering, threshold, and the sound of the others.

What comes back is decided by geometry and level: a flat face and a right-angled hollow corner send
the sound of an image source, a pillar a share of it, an edge little, and a rough face scatters
from wherever the beam meets it. What is detected is the first sound that crosses the threshold.

A ray-tracing sonar in the line of Wilkes, Dudek, Jenkin and Milios, "Modelling sonar range
sensors" (SPIE 1388, 1990), with the acoustic mirrors of Kuc and Siegel (IEEE Transactions on
Pattern Analysis and Machine Intelligence 9(6), 1987). Rays find the faces; distances come from
mirror images, so they are exact for flat faces and do not depend on the number of rays.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import InitVar, dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sim.engines.protocol import RayCaster
from sim.sonar.air import Air
from sim.sonar.firing import Firing, InTurn, Ping, fitted, pings
from sim.sonar.physical import tables
from sim.sonar.physical.array import ArrayModel, ImageArray, PhysicalArray, known_faces
from sim.sonar.physical.detection import Reading
from sim.sonar.physical.fresnel import FOCUS_DB, fresnel_table
from sim.sonar.physical.images.limits import ImageLimits
from sim.sonar.physical.images.setup import CompiledImages
from sim.sonar.physical.interferer import Interferer
from sim.sonar.physical.levels import (
    Acoustics,
    loudest_echo_db,
    mirror_echo_db,
    others_tvg_db,
)
from sim.sonar.physical.piston import Piston
from sim.sonar.physical.receiver import Receiver
from sim.sonar.physical.spread import Transducers, TransducerSpread
from sim.sonar.physical.tracing import TracingLimits
from sim.sonar.physical.turning import edge_share_db
from sim.sonar.protocol import Echoes, SonarArray
from sonarmap import InputError, SonarRing
from sonarmap.errors import finite, one_of, positive
from worlds import World

__all__ = ["PhysicalSonar"]

# So far off the axis faces are looked for that the sound of another sonar may come by. Assumed.
_WIDE_RAD = math.radians(45)
# Nothing leaves a transducer backwards.
_WIDEST_RAD = math.radians(89.9)


@dataclass(frozen=True)
class PhysicalSonar:
    """A ring of sonars that behave like sonars.

    Parameters
    ----------
    name : str
        Name of the preset.
    ring : SonarRing
        Places, nominal cone (for the truths on axis and cone only), nearest and farthest range.
    firing : Firing
        When the sonars fire.
    piston : Piston
        Beam of the transducers.
    receiver : Receiver
        Threshold, time-varied gain, pulse, noise.
    air : Air
        The air that there is.
    assumed_air : Air
        The air for which the robot turns times into ranges.
    max_bounces : int
        Over how many mirroring faces a sound is traced before the face that turns it, >= 0.
    edge_db : float
        Level of an edge at 1 m against a plane at 1 m, decibels, <= 0; the level falls with
        1 / r^2 where a plane's falls with 1 / r. -37 dB: Keller's diffraction by a right-angled
        wedge, seen head-on, at 49.4 kHz (Journal of the Optical Society of America 52, 1962).
    ray_step_rad : float
        Angle between the rays of a fan, at most, radians, > 0. What is narrower than the gap
        between two rays may be missed; ranges do not depend on it.
    interferers : tuple of Interferer
        Sources of sound besides the robot's own.
    spread : TransducerSpread
        How much the ring's transducers differ.
    search : {"auto", "images", "rays"}
        How the sounds that come back are found. "images": they are counted from the room's faces,
        exactly; needs an engine that knows them, as `segments` does. "rays": fans of rays find the
        faces that they meet; any engine casts rays. "auto", the default: images where the faces
        are known.
    sound_life_s : float
        A sound is forgotten this long after it was sent, seconds, > 0. Default: two slots of
        40 ms, so that a sonar detects what the one before it sent.
    beacons : tuple of Interferer, optional
        Former name of `interferers`; counts where it is given.
    """

    name: str
    ring: SonarRing
    firing: Firing = field(default_factory=InTurn)
    piston: Piston = field(default_factory=Piston)
    receiver: Receiver = field(default_factory=Receiver)
    air: Air = field(default_factory=Air)
    assumed_air: Air = field(default_factory=Air)
    max_bounces: int = 1
    edge_db: float = -37.0
    ray_step_rad: float = math.radians(1.0)
    sound_life_s: float = 0.080
    interferers: tuple[Interferer, ...] = ()
    search: str = "auto"
    spread: TransducerSpread = field(default_factory=TransducerSpread)
    beacons: InitVar[tuple[Interferer, ...] | None] = None

    def __post_init__(self, beacons: tuple[Interferer, ...] | None) -> None:
        if beacons is not None:
            object.__setattr__(self, "interferers", beacons)
        object.__setattr__(self, "firing", fitted(self.firing, len(self.ring)))
        if self.max_bounces < 0:
            raise InputError(f"max_bounces must be >= 0, got {self.max_bounces!r}")
        if finite("edge_db", self.edge_db) > 0:
            raise InputError(f"edge_db must be <= 0, got {self.edge_db!r}")
        positive("ray_step_rad", self.ray_step_rad)
        one_of("search", self.search, ("auto", "images", "rays"))
        positive("sound_life_s", self.sound_life_s)

    def replace(self, **changes: object) -> PhysicalSonar:
        """Return this sonar with some fields replaced."""
        return replace(self, **changes)  # type: ignore[arg-type]

    def array(self, rays: RayCaster, world: World, rng: np.random.Generator) -> SonarArray:
        """Return the sonars of one drive, see `sim.sonar.protocol.Sonar`."""
        transducers = self.spread.drawn(len(self.ring), rng)
        return self._array(rays, world, rng, transducers, monostatic=False)

    def _array(
        self,
        rays: RayCaster,
        world: World,
        rng: np.random.Generator,
        transducers: Transducers,
        *,
        monostatic: bool,
    ) -> SonarArray:
        faces = None if self.search == "rays" else known_faces(rays)
        if faces is not None:
            setup = self._images.setup(faces, world, transducers, monostatic=monostatic)
            return ImageArray(setup, self._model, rays, rng)
        if self.search == "images":
            raise InputError("search 'images' needs an engine that knows the room's faces")
        return PhysicalArray(self._model, rays, world, rng, transducers, monostatic=monostatic)

    def listen(
        self,
        rays: RayCaster,
        world: World,
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> Echoes:
        """Fire k transducers without cross-talk between them, see `sim.sonar.protocol.Sonar`.

        They are all alike.
        """
        alike = Transducers.alike(len(axis_rad))
        array = self._array(rays, world, rng, alike, monostatic=True)
        array.fire(0.0, tuple(range(len(axis_rad))), sensor_xy_m, np.asarray(axis_rad))
        return array.detect()

    def randomised(self, noise_factor: float, air: Air) -> PhysicalSonar:
        """Return it with its noise multiplied, in other air, see `sim.sonar.protocol.Sonar`."""
        receiver = replace(
            self.receiver,
            noise_std_m=noise_factor * self.receiver.noise_std_m,
            weak_noise_std_m=noise_factor * self.receiver.weak_noise_std_m,
        )
        return self.replace(receiver=receiver, air=air)

    def compiled(self) -> CompiledImages | None:
        """Return it as numbers, see `sim.sonar.protocol.Sonar`; None by rays or with interferers.

        Rays are cast by engines, and interferers send whatever a person writes.
        """
        return None if self.search == "rays" or self.interferers else self._images

    @property
    def window_s(self) -> float:
        """How long a sonar listens after its firing, seconds."""
        longest = 2 * self.ring.range_max_m / self.assumed_air.speed_mps
        return min(longest, self.firing.listening_s)

    @cached_property
    def limits(self) -> TracingLimits:
        """How far and how finely the compiled steps trace faces."""
        return TracingLimits(
            reach_m=float(self._reaches_m[0]),
            max_bounces=self.max_bounces,
            # The foot of a face may lie between its last ray and the next one.
            margin_rad=6 * self.ray_step_rad,
            # Nobody else listens before the next firing, unless windows overlap.
            least_cross_path_m=0.0 if self.overlapping else self.air.speed_mps * self._least_gap_s,
            axis_number=len(self.bearing_rad) // 2,
            cone_numbers=int((self.bearing_rad <= self.ring.half_angle_rad + 1e-9).sum())
            - len(self.bearing_rad) // 2
            - 1,
            range_max_m=self.ring.range_max_m,
        )

    @cached_property
    def image_limits(self) -> ImageLimits:
        """Which image sources the compiled steps look for."""
        own_s = self._least_own_gap_s
        return ImageLimits(
            reach_m=float(self._reaches_m[0]),
            max_bounces=int(self.max_bounces),
            wide_rad=min(float(self.bearing_rad[-1]), _WIDEST_RAD),
            least_cross_path_m=self.limits.least_cross_path_m,
            least_late_path_m=self.air.speed_mps * own_s,
            is_late=own_s < self.sound_life_s,
            cone_rad=float(self.ring.half_angle_rad),
            range_max_m=float(self.ring.range_max_m),
            spare_db=self._spare_db,
            edge_reach_m=self._edge_reach_m,
        )

    @property
    def _spare_db(self) -> float:
        """How much louder than a nominal transducer's mirror echo a sound may be, decibels."""
        return FOCUS_DB + 2 * self.spread.most_db

    @cached_property
    def _edge_reach_m(self) -> float:
        """How far away an edge is detected at most, metres."""
        heard_m = 0.0
        for half_m in np.linspace(0.02, float(self._reaches_m[0]), 500):
            level_db = loudest_echo_db(self.acoustics, 2 * half_m) + 2 * self.spread.most_db
            if level_db + edge_share_db(self.edge_db, half_m, half_m) > 0:
                heard_m = float(half_m)
        # As far as the next one that was tried.
        return heard_m + float(self._reaches_m[0]) / 499

    @cached_property
    def _least_own_gap_s(self) -> float:
        """Shortest time between two firings of one sonar, seconds."""
        last_s: dict[int, float] = {}
        least_s = math.inf
        for ping in self._pings(scans=3):
            for sonar in ping.sonars:
                least_s = min(least_s, ping.time_s - last_s.get(sonar, -math.inf))
                last_s[sonar] = ping.time_s
        return least_s

    @cached_property
    def _reaches_m(self) -> NDArray[np.float64]:
        """How far sound reaches that is so many whole decibels weaker than on the axis, falling."""
        return self.acoustics.tables[tables.LOST : tables.LOST + tables.LOST_STEPS]

    @cached_property
    def _audible_s(self) -> float:
        """How long after it was sent any sonar may still listen for a sound, seconds."""
        starts_s = [ping.time_s for ping in self._pings(scans=4)]
        waits_s = np.subtract.outer(starts_s, starts_s)
        last_s = waits_s[(waits_s >= 0) & (waits_s < self.sound_life_s)].max()
        return float(min(last_s + self.window_s, self.sound_life_s))

    @cached_property
    def acoustics(self) -> Acoustics:
        """What the compiled steps need of beam, air and receiver."""
        nominal, tone_hz = Air(), self.piston.frequency_hz
        latest_s = max(ping.offset_s for ping in self._pings(scans=2))
        bare = Acoustics(
            speed_mps=self.air.speed_mps,
            absorption_db_per_m=self.air.absorption_db_per_m(tone_hz),
            nominal_speed_mps=nominal.speed_mps,
            nominal_absorption_db_per_m=nominal.absorption_db_per_m(tone_hz),
            assumed_speed_mps=self.assumed_air.speed_mps,
            dynamic_range_db=float(self.receiver.dynamic_range_db),
            gain_share=float(self.receiver.gain_share),
            pulse_s=float(self.receiver.pulse_s),
            blanking_s=float(self.receiver.blanking_s),
            edge_db=float(self.edge_db),
            window_s=float(self.window_s),
            head_start_s=float(latest_s if self.overlapping else -self._least_gap_s),
            life_s=float(self.sound_life_s),
            wavelength_m=self.air.speed_mps / float(tone_hz),
            path_step_m=self.air.speed_mps * self.sound_life_s / (tables.PATH_STEPS - 1),
            tables=np.empty(0),
        )
        return bare._replace(tables=self._tables(bare))

    def _tables(self, bare: Acoustics) -> NDArray[np.float64]:
        """Return what is looked up."""
        path_m = bare.path_step_m * np.arange(tables.PATH_STEPS)
        own_db = np.array([loudest_echo_db(bare, path) for path in path_m])
        others_db = np.array(
            [mirror_echo_db(bare, path) + others_tvg_db(bare, path) for path in path_m]
        )
        # What focuses sound, and the most sensitive transducers, are heard from farther away; up
        # to the next path that was tried.
        echo_db = np.maximum(own_db, others_db) + self._spare_db
        echo_db[path_m > bare.speed_mps * self._audible_s] = -math.inf
        loud = echo_db[:, None] > np.arange(tables.LOST_STEPS)
        last = np.where(loud.any(axis=0), len(path_m) - 1 - loud[::-1].argmax(axis=0), 0)
        return tables.packed(
            beam_db=self.piston.level_db(np.linspace(0, math.pi, tables.BEAM_STEPS)),
            own_db=own_db,
            others_db=np.maximum.accumulate(others_db[::-1])[::-1],
            lost_reach_m=np.maximum(bare.path_step_m * (last + 1) / 2, 0.02),
            fresnel=fresnel_table(),
        )

    @cached_property
    def overlapping(self) -> bool:
        """Whether a sonar listens while another one's sound is fresh."""
        together = any(len(ping.sonars) > 1 for ping in self._pings(scans=2))
        return together or self._least_gap_s < self.window_s

    @cached_property
    def _least_gap_s(self) -> float:
        """Shortest time between two firings, seconds."""
        return float(np.diff([ping.time_s for ping in self._pings(scans=3)]).min())

    def _pings(self, scans: int) -> Iterator[Ping]:
        return pings(self.firing, len(self.ring), scans=scans)

    @cached_property
    def bearing_rad(self) -> NDArray[np.float64]:
        """Bearings of a fan, the cone's edges and the axis among them.

        Dense in the main lobe; wider where only side lobes reach, where small things are lost; and
        as far out as the sound of another sonar may come from, by large faces.
        """
        half = self.ring.half_angle_rad
        # Near targets are the loudest.
        loudest_db = loudest_echo_db(self.acoustics, 2 * max(self.ring.range_min_m, 0.05))
        loudest_db += self._spare_db
        reach = max(self.piston.reach_rad(loudest_db) + self.spread.most_rad, half)
        reach = min(reach, math.pi / 2)
        lobe = min(self.piston.null_rad + self.spread.most_rad, reach)
        stops = sorted({lobe, half, reach})
        if self.overlapping and reach < _WIDE_RAD:
            stops.append(_WIDE_RAD)
        side, last = [0.0], 0.0
        for stop in stops:
            step = self.ray_step_rad * (1 if stop <= lobe else 3 if stop <= reach else 5)
            count = math.ceil((stop - last) / step - 1e-9)
            side += [last + (stop - last) * k / count for k in range(1, count + 1)]
            last = stop
        return np.array([-bearing for bearing in side[:0:-1]] + side)

    @cached_property
    def ray_reach_m(self) -> NDArray[np.float64]:
        """How far the rays of a fan go: as far as detection; in the cone as far as the truth."""
        table_db = self.acoustics.tables[: tables.BEAM_STEPS]
        angles, lean = np.linspace(0, math.pi, table_db.size), self.spread.most_rad
        # The beam may lean either way.
        sent_db = np.max(
            [
                np.interp(np.abs(self.bearing_rad + turn), angles, table_db)
                for turn in np.linspace(-lean, lean, 5)
            ],
            axis=0,
        )
        far_m = self._reaches_m[np.clip(np.floor(-sent_db), 0, tables.LOST_STEPS - 1).astype(int)]
        in_cone = np.abs(self.bearing_rad) <= self.ring.half_angle_rad + 1e-9
        reach_m: NDArray[np.float64] = np.maximum(
            far_m, np.where(in_cone, self.ring.range_max_m, 0.1)
        )
        return reach_m

    @cached_property
    def reading(self) -> Reading:
        """What is read of what is detected."""
        return Reading(
            float(self.receiver.noise_std_m),
            float(self.receiver.weak_noise_std_m),
            float(self.receiver.quantum_m),
            float(self.ring.range_min_m),
            float(self.ring.range_max_m),
        )

    @cached_property
    def _model(self) -> ArrayModel:
        return ArrayModel(
            piston=self.piston,
            interferers=self.interferers,
            reading=self.reading,
            acoustics=self.acoustics,
            limits=self.limits,
            bearing_rad=self.bearing_rad,
            ray_reach_m=self.ray_reach_m,
        )

    @cached_property
    def _images(self) -> CompiledImages:
        return CompiledImages(
            sonars=len(self.ring),
            acoustics=self.acoustics,
            limits=self.image_limits,
            reading=self.reading,
            spread=self.spread,
        )
