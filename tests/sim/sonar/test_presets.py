"""Sonars by name, and what a sonar says of itself: how it is randomised, whether it compiles."""

import math

import pytest

import sim
import worlds
from sim.sonar.cone.compiled import CompiledCone
from sim.sonar.physical.images.setup import CompiledImages
from sim.sonar.presets import PRESETS, preset
from sonarmap import AMIGOBOT, InputError


def test_presets_are_a_mapping_of_names_to_sonars():
    assert list(PRESETS) == ["thesis", "aria", "webots", "physical"]
    assert all(sonar.name == name for name, sonar in PRESETS.items())
    assert preset("thesis") is PRESETS["thesis"]


def test_a_sonar_of_ones_own_is_found_by_its_module(mine):
    mine.WIDE = preset("aria").replace(rays=61)
    mine.make = lambda: mine.WIDE
    assert preset("mine:WIDE") is preset("mine:make") is mine.WIDE
    office = worlds.load("office")
    log = sim.simulate(office, scans=3, seed=0, sonar="mine:WIDE", engine="segments")
    assert len(log) == 24


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("fysical", r"sonar 'fysical' is unknown; did you mean 'physical'\?"),
        ("mine:NOTHING", r"sonar 'mine:NOTHING' cannot be imported: 'mine' has no 'NOTHING'"),
        ("mine:number", r"sonar 'mine:number' must be a sonar or make one, got 3"),
        ("sim:ConeSonar", r"sonar 'sim:ConeSonar' must be made without arguments: .*missing"),
        ("no_such_module:X", "sonar 'no_such_module:X' cannot be imported"),
    ],
)
def test_what_is_no_sonar_is_refused(mine, name, message):
    mine.number = 3
    with pytest.raises(InputError, match=message):
        preset(name)


def test_a_cone_is_randomised_in_noise_and_scale():
    cold = preset("aria").randomised(3.0, sim.Air(0.0))
    assert cold.noise_std_m == pytest.approx(0.003)
    assert cold.range_scale == pytest.approx(math.sqrt(293.15 / 273.15))


def test_a_physical_sonar_is_randomised_in_noise_and_air():
    cold = preset("physical").randomised(3.0, sim.Air(0.0))
    assert cold.receiver.noise_std_m == pytest.approx(0.003)
    assert cold.receiver.weak_noise_std_m == pytest.approx(0.015)
    assert cold.air == sim.Air(0.0)
    assert cold.assumed_air == sim.Air()


def test_a_sonar_without_noise_says_so():
    with pytest.raises(InputError, match="sonar 'webots' has neither noise nor air to randomise"):
        preset("webots").randomised(2.0, sim.Air())


def test_sonars_compile_as_what_they_are():
    aria, webots = preset("aria").compiled(), preset("webots").compiled()
    assert isinstance(aria, CompiledCone)
    assert (aria.rays, aria.max_bounces, aria.critical_rad) == (None, 2, None)
    assert (webots.rays, webots.max_bounces, webots.silent_m) == (9, 0, 5.0)
    assert preset("aria").replace(rays=31).compiled().rays == 31
    physical = preset("physical")
    assert isinstance(physical.compiled(), CompiledImages)
    assert physical.compiled().limits == physical.image_limits
    assert physical.replace(search="rays").compiled() is None
    source = sim.Interferer(1.0, 0.0, period_s=0.1)
    assert physical.replace(interferers=(source,)).compiled() is None


def test_former_names_stay():
    assert sim.Beacon is sim.Interferer
    assert sim.Ears is sim.SonarArray
    source = sim.Interferer(1.0, 0.0, period_s=0.1)
    former = sim.PhysicalSonar("s", AMIGOBOT, beacons=(source,))
    assert former == sim.PhysicalSonar("s", AMIGOBOT, interferers=(source,))
    # A copy keeps them, and takes others by either name.
    assert former.replace(max_bounces=0).interferers == (source,)
    assert former.replace(interferers=()).interferers == ()
    assert former.replace(beacons=()).interferers == ()
