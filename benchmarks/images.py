"""What the physical sonar costs by image sources and by rays.

Both searches run in turn in one process, so that what else the machine does meets them alike.
"""

import math
from itertools import product
from time import perf_counter, process_time

import numpy as np

import sim
import worlds
from sim import AllAtOnce, Receiver
from sim.engines.segments import Segments
from sim.runs.arguments import DriveArguments
from sim.runs.batch.drives import BatchDrive, simulate_batch
from sim.runs.plain import plain_log
from sim.sonar.firing import pings
from sim.sonar.presets import preset

SCANS, STOPS, ROUNDS = 150, 40, 6
PHYSICAL = preset("physical")
QUIET = PHYSICAL.replace(
    receiver=Receiver(noise_std_m=0, weak_noise_std_m=0, quantum_m=0), search="images"
)
Stops = list[tuple[float, float, float]]


def main() -> None:
    office = worlds.load("office")
    for search, step_deg in (("rays", 1.0), ("images", 1.0)):
        sonar = PHYSICAL.replace(search=search, ray_step_rad=math.radians(step_deg))
        drive_us, sonar_us = min(drive_us_of(office, sonar) for _ in range(4)), kernel_us(
            office, sonar
        )  # fmt: skip
        print(
            f"office, in turn, one bounce, {search}: {1e6 / drive_us:,.0f} readings/s step "
            f"by step, of {drive_us:.0f} us a reading the sonar takes {sonar_us:.0f}"
        )
    whole_drives(office)
    for firing, bounces in product((PHYSICAL.firing, AllAtOnce(0.1)), range(4)):
        sonar = PHYSICAL.replace(firing=firing, max_bounces=bounces)
        cost = [kernel_us(office, sonar.replace(search=search)) for search in ("rays", "images")]
        print(
            f"{type(firing).__name__}, {bounces} bounces: {cost[0]:.0f} us a reading by rays, "
            f"{cost[1]:.0f} by images"
        )


def whole_drives(room: worlds.World) -> None:
    """Print readings a second of drives that run compiled, beside one step by step."""
    plain_us = 0.0
    rates: dict[int, float] = {1: 0.0, 2: 0.0}
    # Each round does all, so that what else the machine does meets them alike.
    for seed in range(ROUNDS):
        asked = DriveArguments.of(
            room, scans=300, seed=seed, driver="route", sonar=PHYSICAL, engine="segments"
        )
        begin = perf_counter()
        readings = len(plain_log(asked))
        cost_us = (perf_counter() - begin) / readings * 1e6
        plain_us = min(plain_us or cost_us, cost_us)
        drives = [BatchDrive(room, 300, k, "route", PHYSICAL) for k in range(8)]
        for threads in rates:
            begin = perf_counter()
            readings = sum(len(log) for _, log in simulate_batch(drives, workers=threads))
            rates[threads] = max(rates[threads], readings / (perf_counter() - begin))
    print(
        f"office, in turn, one bounce, whole drives: {rates[1]:,.0f} readings/s by one thread "
        f"(wanted 60,000), {rates[2]:,.0f} by two (wanted 110,000); "
        f"{1e6 / rates[1]:.0f} us a reading, step by step {plain_us:.0f}"
    )


def stops_in(room: worlds.World, count: int) -> Stops:
    """Return poses where the robot fits."""
    rng, stops = np.random.default_rng(3), []
    while len(stops) < count:
        x, y = rng.uniform(room.bounds_m[:2], room.bounds_m[2:])
        if room.has_room_at(x, y, radius_m=0.2):
            stops.append((x, y, rng.uniform(-math.pi, math.pi)))
    return stops


def read(room: worlds.World, sonar: sim.PhysicalSonar, stops: Stops) -> tuple[list, float]:
    """Return the echoes of a scan at each pose, and the processor time it took, seconds."""
    ring, order = sonar.ring, list(pings(sonar.firing, len(sonar.ring), scans=1))
    places = [ring.sensor_xy_m(slice(None), *stop) for stop in stops]
    with Segments(room, room.start) as engine:
        array = sonar.array(engine, room, np.random.default_rng(0))
        begin, echoes = process_time(), []
        for k, (place, stop) in enumerate(zip(places, stops, strict=True)):
            for ping in order:
                axes = stop[2] + ring.heading_rad
                array.fire(10 * k + ping.time_s, ping.sonars, place, axes)
            echoes.append(array.detect())
    return echoes, process_time() - begin


def kernel_us(room: worlds.World, sonar: sim.PhysicalSonar) -> float:
    """Return the least processor time of a reading at some poses, without driving."""
    stops = stops_in(room, STOPS)
    return min(read(room, sonar, stops)[1] for _ in range(6)) / STOPS / 8 * 1e6


def drive_us_of(room: worlds.World, sonar: sim.PhysicalSonar) -> float:
    """Return the time of a reading of a whole drive step by step."""
    begin = perf_counter()
    plain_log(
        DriveArguments.of(room, scans=SCANS, seed=0, driver="route", sonar=sonar, engine="segments")
    )
    return (perf_counter() - begin) / SCANS / 8 * 1e6


if __name__ == "__main__":
    main()
