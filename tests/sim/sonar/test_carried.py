"""Another ring for a sonar."""

import math

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

import sim
import sonarmap as sm
import worlds
from sim.sonar import presets
from sim.sonar.carried import with_ring

THREE = sm.SonarRing("three", [0.1, 0.1, 0.1], [0.05, 0.0, -0.05], [0.5, 0, -0.5], 0.2, 0.05, 2.5)


AROUND = np.linspace(-math.pi, math.pi, 16, endpoint=False)
SIXTEEN = sm.SonarRing(
    "sixteen", 0.15 * np.cos(AROUND), 0.15 * np.sin(AROUND), AROUND, 0.26, 0.1, 4.0
)


class Own:
    """A person's own sonar, no dataclass."""

    name, ring, firing = "own", THREE, sim.AllAtOnce(0.1)


@pytest.fixture
def toml(tmp_path):
    THREE.write(tmp_path / "three.toml")
    return tmp_path / "three.toml"


@pytest.mark.parametrize("name", ["thesis", "aria", "webots", "physical"])
@pytest.mark.parametrize("ring", [THREE, SIXTEEN, "hc-sr04-8"])
def test_a_sonar_fires_every_ring(name, ring):
    log = sim.simulate(
        worlds.load("l-shape"), scans=3, seed=0, sonar=name, ring=ring, engine="segments"
    )
    ring = sm.ring(ring) if isinstance(ring, str) else ring
    assert log.ring == ring
    assert np.array_equal(np.unique(log.sonar), np.arange(len(ring)))
    assert len(log) == 3 * len(ring)


def test_a_name_a_file_and_a_ring_are_one(toml):
    room, logs = worlds.load("l-shape"), []
    for ring in (THREE, toml, str(toml)):
        logs.append(
            sim.simulate(room, scans=5, seed=1, sonar="thesis", ring=ring, engine="segments")
        )
    given = presets.preset("thesis").replace(ring=THREE)
    logs.append(sim.simulate(room, scans=5, seed=1, sonar=given, engine="segments"))
    for log in logs[1:]:
        assert np.array_equal(log.range_m, logs[0].range_m)
    assert logs[0].ring == THREE


def test_without_another_ring_a_sonar_stays_what_it_is():
    for name in presets.PRESETS.shipped:
        sonar = presets.preset(name)
        assert with_ring(sonar, None) is sonar


@pytest.mark.parametrize(
    ("sonar", "ring", "message"),
    [
        ("thesis", "amigo", "ring 'amigo' is unknown; did you mean 'amigobot'"),
        ("thesis", "gone.toml", "gone.toml: no such file"),
        ("thesis", 3, "ring"),
        ("thesis", "pioneer3dx", "ring 'pioneer3dx' is larger than the robot: sonar 11 sits"),
        (Own(), THREE, "sonar 'own' has no field ring: it takes no other ring"),
    ],
)
def test_a_ring_that_does_not_fit_is_refused(sonar, ring, message):
    sonar = presets.preset(sonar) if isinstance(sonar, str) else sonar
    with pytest.raises(sm.InputError, match=message):
        with_ring(sonar, ring)


@pytest.mark.parametrize("form", ["name", "file", "ring"])
def test_an_environment_has_the_sonars_of_its_ring_and_its_specification_keeps_them(form, toml):
    ring = {"name": "hc-sr04-3", "file": toml, "ring": THREE}[form]
    env = gymnasium.make("sim:sonarbed/Navigate-v1", ring=ring)
    assert env.observation_space["range"].shape == (3,)
    first, _ = env.reset(seed=0)
    again = gymnasium.make(EnvSpec.from_json(env.spec.to_json()))
    assert np.array_equal(again.reset(seed=0)[0]["range"], first["range"])
    # The ring stays when an episode has another sonar.
    assert env.reset(seed=0, options={"sonar": "thesis"})[0]["range"].shape == (3,)
    vector = gymnasium.make_vec(
        "sim:sonarbed/Navigate-v1", num_envs=2, vectorization_mode="vector_entry_point", ring=ring
    )
    assert vector.single_observation_space["range"].shape == (3,)
