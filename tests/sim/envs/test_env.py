"""The battery that every environment, with every option, has to stand."""

import math
import os
import pickle
import subprocess
import sys

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, MultiBinary
from gymnasium.utils.env_checker import check_env
from rooms import closed_room

import sim
from sim.envs.pictures.drawing import ROBOT_COLOURS
from sim.envs.registration import FORMER_IDS, IDS
from sim.sonar import presets as sonars
from sim.sonar.firing import Slot
from sonarmap import InputError, SonarRing
from worlds import load

OPTIONS = {
    "plain": {},
    "wheels": {"action": "wheels"},
    "discrete": {"action": "discrete"},
    "patch": {"map_patch": 20},
    "webots": {"sonar": "webots"},
    "thesis": {"sonar": "thesis", "control_s": 0.05},
    "rooms": {"world": ["office", "clutter", "thesis-exp2"], "randomisation": {"noise": (1, 5)}},
    "bullet": {"engine": "bullet"},
    "physical": {"sonar": "physical"},
}
QUICK = [name for name in OPTIONS if name not in ("bullet", "physical")]


def make(name, **options):
    return gymnasium.make(f"sim:{name}", **options)


def roll(env, steps, *, seed, action_seed=0):
    """Return all that an environment told in so many steps."""
    env.action_space.seed(action_seed)
    told = [env.reset(seed=seed)]
    for _ in range(steps):
        step = env.step(env.action_space.sample())
        told.append(step)
        if step[2] or step[3]:
            told.append(env.reset())
    return told


def flat(told):
    """Return everything told as one list of numbers."""
    numbers = []
    for part in told:
        for thing in part:
            if isinstance(thing, dict):
                numbers += flat([thing.values()])
            else:
                numbers += np.ravel(thing).astype(float).tolist()
    return numbers


@pytest.fixture(params=IDS)
def name(request):
    return request.param


@pytest.mark.engine
@pytest.mark.parametrize("option", OPTIONS)
def test_gymnasiums_own_checker_is_content(name, option):
    env = make(name, **OPTIONS[option]).unwrapped
    check_env(env, skip_render_check=True)
    env.close()


def test_gymnasiums_checker_is_content_with_the_frames(name, monkeypatch):
    pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    check_env(make(name, render_mode="rgb_array").unwrapped)


@pytest.mark.parametrize("option", QUICK)
def test_every_observation_is_in_its_space_and_no_element_is_constant(name, option):
    env = make(name, **OPTIONS[option])
    seen = []
    for seed in range(3):
        for told in roll(env, 120, seed=seed, action_seed=seed):
            assert env.observation_space.contains(told[0])
            assert all(np.isfinite(values).all() for values in told[0].values())
            seen.append(told[0])
    for key in seen[0]:
        values = np.array([observation[key] for observation in seen], float)
        varies = np.ptp(values, axis=0) > 0
        if key == "map":
            # The corners of the patch may lie outside of a small room all the time.
            assert varies.mean() > 0.3
        elif key == "validity":
            # In these rooms some sonars always have an echo, but not all of them.
            assert varies.any() or OPTIONS[option].get("sonar") == "webots"
        else:
            assert varies.all(), key


@pytest.mark.engine
@pytest.mark.parametrize("option", ["rooms", "patch", "bullet", "physical"])
def test_the_same_seed_gives_the_same_trajectory(name, option):
    steps = 15 if option in ("bullet", "physical") else 60
    one, other = (make(name, **OPTIONS[option]) for _ in range(2))
    first = flat(roll(one, steps, seed=0))  # 0 is a seed
    # Another environment runs in between, and this one has lived before.
    roll(make(name, world="corridor"), 5, seed=3)
    assert flat(roll(other, steps, seed=0)) == first
    assert flat(roll(one, steps, seed=0)) == first
    assert flat(roll(one, steps, seed=1)) != first
    one.close()
    other.close()


def test_resets_differ_and_go_on_with_the_generator(name):
    env, again = make(name, world="office"), make(name, world="office")
    env.reset(seed=5)
    again.reset(seed=5)
    begins = [env.reset()[1]["true_pose"] for _ in range(5)]
    assert len({tuple(pose) for pose in begins}) == 5
    assert np.array_equal(begins, [again.reset()[1]["true_pose"] for _ in range(5)])


@pytest.mark.parametrize("option", ["plain", "patch", "discrete"])
def test_observations_share_no_memory(name, option):
    env = make(name, **OPTIONS[option])
    told = [observation for observation, *_ in roll(env, 3, seed=0)]
    copies = [{key: values.copy() for key, values in each.items()} for each in told]
    for i, one in enumerate(told):
        for other in told[i + 1 :]:
            for key in one:
                assert not np.shares_memory(one[key], other[key])
    for observation in told:
        for values in observation.values():
            values[...] = 0
    env.step(env.action_space.sample())
    assert not all((copy["range"] == 0).all() for copy in copies)


def test_closing_twice_is_fine_and_then_nothing_goes(name):
    env = make(name).unwrapped
    env.reset(seed=0)
    env.close()
    env.close()
    with pytest.raises(gymnasium.error.ClosedEnvironmentError, match="is closed"):
        env.step(env.action_space.sample())
    with pytest.raises(gymnasium.error.ClosedEnvironmentError, match="is closed"):
        env.reset()


def test_two_environments_in_one_process_do_not_meet(name):
    alone = roll(make(name, world="clutter"), 30, seed=2)
    one, two = make(name, world="clutter"), make(name, world="office")
    one.action_space.seed(0)
    told = [one.reset(seed=2)]
    two.reset(seed=9)
    for _ in range(30):
        told.append(one.step(one.action_space.sample()))
        two.step(np.array([0.5, -0.5], np.float32))
        if told[-1][2]:
            told.append(one.reset())
    assert flat(told) == flat(alone)


@pytest.mark.engine
@pytest.mark.parametrize("engine", ["segments", "bullet"])
def test_workers_of_their_own_process_do_not_meet(engine):
    single = [
        roll(make("sonarbed/Navigate-v1", engine=engine), 8, seed=seed, action_seed=seed)
        for seed in (4, 5)
    ]
    vector = gymnasium.make_vec(
        "sim:sonarbed/Navigate-v1", num_envs=2, vectorization_mode="async", engine=engine
    )
    actions = []
    for seed in (4, 5):
        space = make("sonarbed/Navigate-v1").action_space
        space.seed(seed)
        actions.append([space.sample() for _ in range(8)])
    observation, _ = vector.reset(seed=4)
    for step in range(9):
        for row in (0, 1):
            expected = single[row][step][0]
            for key, values in observation.items():
                assert np.array_equal(values[row], expected[key])
        if step < 8:
            observation = vector.step(np.array([actions[0][step], actions[1][step]]))[0]
    vector.close()


def test_the_time_limit_is_the_registrations(name):
    limit = gymnasium.spec(name).max_episode_steps
    env = make(name, world="office", start="world")
    env.reset(seed=0)
    still = np.zeros(2, np.float32)
    for step in range(1, limit + 1):
        _, _, terminated, truncated, _ = env.step(still)
        assert not terminated
        assert truncated == (step == limit)


def test_a_robot_that_keeps_pushing_a_wall_is_stuck():
    room = closed_room(1.0)
    env = make("sonarbed/FollowWall-v1", world=room, start="world", action="wheels").unwrapped
    env.reset(seed=0)
    full = np.ones(2, np.float32)
    steps, terminated = 0, False
    touching = 0
    while not terminated:
        _, _, terminated, _, info = env.step(full)
        steps += 1
        touching += info["reward_terms"]["collision"]
        assert steps < 200
    assert touching == 20  # two seconds
    assert info["stuck"]
    with pytest.raises(gymnasium.error.ResetNeeded, match="the episode has ended"):
        env.step(full)
    env.reset()
    env.step(full)


def test_a_step_before_the_first_reset_is_refused():
    env = make("sonarbed/Explore-v1").unwrapped
    with pytest.raises(gymnasium.error.ResetNeeded, match="before the first step"):
        env.step(np.zeros(2))


@pytest.mark.parametrize(
    ("mode", "action", "message"),
    [
        ("velocity", [0.0], r"must have shape \(2,\), got \(1,\)"),
        ("velocity", np.zeros((2, 2)), r"must have shape \(2,\), got \(2, 2\)"),
        ("velocity", [math.nan, 0.0], r"must be within \[-1, 1\]"),
        ("wheels", [0.0, 1.01], r"must be within \[-1, 1\]"),
        ("wheels", ["left", "right"], "must be numbers"),
        ("wheels", None, "must have shape|must be within"),
        ("discrete", 6, "must be a whole number 0 to 5, got 6"),
        ("discrete", -1, "must be a whole number 0 to 5, got -1"),
        ("discrete", 1.0, "must be a whole number 0 to 5, got 1.0"),
        ("discrete", [1, 2], r"must be a whole number, got \[1, 2\]"),
    ],
)
def test_bad_actions_are_refused(mode, action, message):
    env = make("sonarbed/Explore-v1", action=mode).unwrapped
    env.reset(seed=0)
    with pytest.raises(gymnasium.error.InvalidAction, match=message):
        env.step(action)
    env.step(env.action_space.sample())  # and nothing is broken


BAD_ARGUMENTS = [
    ({"engine": "bulet"}, r"engine 'bulet' is unknown; did you mean 'bullet'\?"),
    ({"action": "speed"}, "action 'speed' is unknown"),
    ({"engine": 3}, "engine must be a name, got 3"),
    ({"action": ["wheels"]}, r"action \['wheels'\] is unknown"),
    ({"map_patch": -1}, "map_patch must be >= 0, got -1"),
    ({"map_patch": "16"}, "map_patch must be a number, got '16'"),
    ({"map_patch": 16.5}, "map_patch must be a whole number, got 16.5"),
    ({"map_patch": True}, "map_patch must be a number, got True"),
    ({"map_patch": 10**6}, "map_patch must be <= 1000, got 1000000"),
    ({"control_s": 0.0012}, r"control_s must be a multiple of 0.005 s, got 0.0012"),
    ({"control_s": "x"}, "control_s must be a number, got 'x'"),
    ({"control_s": True}, "control_s must be a number, got True"),
    ({"control_s": 100}, "control_s must be <= 10 s, got 100"),
    ({"control_s": math.inf}, "control_s must be > 0, got inf"),
    ({"map_resolution_m": "0.1"}, "map_resolution_m must be a number, got '0.1'"),
    ({"map_range_m": math.inf}, "map_range_m must be > 0, got inf"),
    ({"validity": "flags"}, "validity 'flags' is unknown; known: box, multibinary"),
    ({"render_mode": 3}, "render_mode 3 is unknown"),
    ({"map_resolution_m": 0.0}, "map_resolution_m must be > 0"),
    ({"map_range_m": -1.0}, "map_range_m must be > 0"),
    ({"render_mode": "humans"}, "render_mode 'humans' is unknown; did you mean 'human'"),
]
BAD_OPTIONS = [
    ({"world": "ofice"}, r"'ofice'.*did you mean 'office'\?"),
    ({"world": []}, "world must name at least one room, got none"),
    ({"sonar": "fysical"}, r"sonar 'fysical' is unknown; did you mean 'physical'\?"),
    ({"start": "anywhere"}, "start must be 'random' or 'world' or 3 finite numbers"),
    ({"start": (1.0, 2.0)}, "start must be 'random' or 'world' or 3 finite numbers"),
    ({"start": (math.nan, 2.0, 0.0)}, "start must be .* 3 finite numbers"),
    ({"start": (0.0, 0.0, 0.0)}, r"start of \(0, 0\) m must leave the robot .* clear"),
    ({"goal": (1.0, 2.0, 3.0)}, "goal must be 'random' or 2 finite numbers"),
    ({"start": (True, 2.0, 0.0)}, "start must be .* 3 finite numbers"),
    ({"start": ("1", "2", "0")}, "start must be .* 3 finite numbers"),
    ({"start": 5}, "start must be .* 3 finite numbers, got 5"),
    ({"goal": {1.0, 2.0}}, "goal must be 'random' or 2 finite numbers"),
    ({"world": 3}, "world must be the name of a room, a file, a World or a sequence of them"),
    ({"sonar": None}, "sonar must be the name of a preset or a sonar, got None"),
    ({"odometry": "exact"}, "odometry must be OdometryModel or a mapping of its fields"),
    ({"goal": (99.0, 0.0)}, "goal of .* must be where the robot"),
    ({"randomisation": {"colour": 1}}, "randomisation 'colour' is unknown"),
    ({"randomisation": {"noise": (2, 1)}}, "noise must be two numbers, the lower one first"),
    ({"randomisation": {"noise": (0, 1)}}, "must be > 0"),
    ({"randomisation": {"temperature_c": (0, 90)}}, r"temperature_c must be within \[-20, 50\]"),
    ({"randomisation": {"materials": ["velvet"]}}, "material 'velvet' is unknown"),
]


@pytest.mark.parametrize(("arguments", "message"), BAD_ARGUMENTS)
def test_bad_arguments_are_refused(arguments, message):
    with pytest.raises((InputError, gymnasium.error.Error), match=message):
        sim.envs.NavigateEnv(**arguments)


@pytest.mark.parametrize(
    ("options", "message"),
    [*BAD_OPTIONS, ({"wrld": "office"}, "option 'wrld' is unknown; did you mean 'world'")],
)
def test_bad_options_are_refused(options, message):
    env = make("sonarbed/Navigate-v1").unwrapped
    env.reset(seed=0)
    with pytest.raises(InputError, match=message):
        env.reset(options=options)
    env.reset()
    env.step(env.action_space.sample())


@pytest.mark.parametrize(("options", "message"), BAD_OPTIONS)
def test_they_are_refused_as_arguments_too(options, message):
    def begin():
        env = sim.envs.NavigateEnv(**options)
        env.reset(seed=0)

    with pytest.raises(InputError, match=message):
        begin()


def test_options_of_a_reset_hold_for_one_episode():
    env = make("sonarbed/Navigate-v1", world="office").unwrapped
    options = {"world": "clutter", "start": (1.0, 1.0, 0.5), "goal": (3.0, 3.0), "sonar": "thesis"}
    clutter = load("clutter")
    options["start"] = (clutter.start.x_m, clutter.start.y_m, 0.5)
    _, info = env.reset(seed=0, options=options)
    assert info["true_pose"].tolist() == list(options["start"])
    assert env.batch.setup_of(0).world.name == "clutter"
    assert env.batch.setup_of(0).sonar.name == "thesis"
    assert env.batch.task.goal_of(0) == (3.0, 3.0)
    env.step(env.action_space.sample())
    env.reset()
    assert env.batch.setup_of(0).world.name == "office"
    assert env.batch.setup_of(0).sonar.name == "aria"


def test_a_world_may_be_a_file(tmp_path):
    file = tmp_path / "hall.toml"
    file.write_text(
        'title = "a hall"\nsource = "a test"\n'
        "bounds_m = [0, 0, 4, 3]\nstart = { x_m = 1, y_m = 1, heading_deg = 0 }\n"
        '[[wall]]\nname = "walls"\npoints_m = [[0, 0], [4, 0], [4, 3], [0, 3]]\nclosed = true\n'
        'side = "right"\nthickness_m = 0.1\nheight_m = 2\nmaterial = "brick"\n'
    )
    env = make("sonarbed/Explore-v1", world=file)
    env.reset(seed=0)
    assert env.unwrapped.batch.setup_of(0).world.name == "hall"


def test_randomisation_draws_materials_noise_and_air_for_every_episode():
    drawn = {"materials": ("metal", "foam"), "noise": (1, 4), "temperature_c": (0, 40)}
    env = make("sonarbed/Explore-v1", randomisation=drawn, world="clutter").unwrapped
    setups = []
    for seed in range(6):
        env.reset(seed=seed)
        setups.append(env.batch.setup_of(0))
    noise = [setup.sonar.noise_std_m for setup in setups]
    scales = [setup.sonar.range_scale for setup in setups]
    assert 0.001 <= min(noise) < max(noise) <= 0.004
    # 331.3 sqrt(1 + t / 273.15) m/s at 0, 20 and 40 degrees.
    assert 343.2 / 354.8 <= min(scales) < max(scales) <= 343.3 / 331.3
    materials = {solid.material.name for setup in setups for solid in setup.world.solids}
    assert materials == {"metal", "foam"}
    assert len({tuple(s.material.name for s in each.world.solids) for each in setups}) > 1


def test_a_sonar_that_fires_between_steps_of_the_physics_is_refused():
    odd = sonars.preset("aria").replace(scan_period_s=0.001)
    with pytest.raises(InputError, match=r"scan_period_s must be a multiple of 0.005 s, got 0.001"):
        sim.envs.NavigateEnv(sonar=odd)
    env = sim.envs.NavigateEnv()
    with pytest.raises(InputError, match=r"scan_period_s must be a multiple of 0.005 s"):
        env.reset(seed=0, options={"sonar": odd})


class Impatient(sim.InTurn):
    """Fires between steps of the physics, and says nothing of it by its period."""

    def slots(self, scan, sonars):
        return tuple(Slot(0.001 * i, (i,)) for i in range(sonars))


@pytest.mark.parametrize(
    "firing",
    [
        sim.InTurn(order=(0, 1, 2, 9, 4, 5, 6, 7)),
        sim.InTurn(order=(3, 1, 2, 0, 4, 5, 6, 8)),
        sim.Eeruf(period_s=0.32, order=(9,)),
        sim.Eeruf(period_s=0.32, lag_even_s=0.001),
        sim.AllAtOnce(0.32 + 1e-4),
        Impatient(),
    ],
)
def test_a_sonar_is_checked_at_reset_as_at_the_begin(firing):
    # Of the same ring and, as a rule, the same period as the one before.
    sonar = sim.PhysicalSonar("odd", sonars.preset("physical").ring)
    object.__setattr__(sonar, "firing", firing)
    with pytest.raises(InputError) as at_first:
        sim.envs.NavigateEnv(sonar=sonar)
    env = sim.envs.NavigateEnv(sonar="physical")
    env.reset(seed=0)
    with pytest.raises(InputError) as at_reset:
        env.reset(options={"sonar": sonar})
    assert str(at_reset.value) == str(at_first.value)
    env.reset()
    env.step(env.action_space.sample())


def ring_of(sonars_of_it):
    heading = np.linspace(-2.0, 2.0, sonars_of_it)
    return SonarRing("own", 0.1 * np.cos(heading), 0.1 * np.sin(heading), heading, 0.26, 0.1, 4.0)


@pytest.mark.parametrize("size", [1, 3, 16])
@pytest.mark.parametrize("engine", ["segments", "physical"])
def test_the_observation_follows_the_ring(size, engine):
    ring = ring_of(size)
    sonar = (
        sonars.preset("aria").replace(ring=ring)
        if engine == "segments"
        else sim.PhysicalSonar("own", ring, firing=sim.InTurn(order=tuple(range(size))))
    )
    env = gymnasium.make("sonarbed/Explore-v1", sonar=sonar, map_patch=16)
    assert (
        env.observation_space["range"].shape == env.observation_space["validity"].shape == (size,)
    )
    for observation, *_ in roll(env, 10, seed=0):
        assert env.observation_space.contains(observation)
    with pytest.raises(InputError, match=f"must have {size} sonars, as the observation space says"):
        env.reset(options={"sonar": "aria"})
    many = gymnasium.make_vec("sonarbed/Explore-v1", num_envs=3, sonar=sonar)
    assert many.reset(seed=0)[0]["range"].shape == (3, size)


@pytest.mark.parametrize("name", FORMER_IDS)
def test_the_former_ids_observe_as_they_did(name):
    former, now = gymnasium.make(name), gymnasium.make(name.replace("-v0", "-v1"))
    assert former.observation_space["validity"] == MultiBinary(8)
    assert now.observation_space["validity"] == Box(0, 1, (8,), np.float32)
    told = [roll(env, 20, seed=0) for env in (former, now)]
    assert flat(told[0]) == flat(told[1])
    assert told[0][0][0]["validity"].dtype == np.int8
    assert former.observation_space.contains(told[0][0][0])


def test_every_space_is_a_box(name):
    """What frame stacks, normalisation and the like of most libraries take."""
    env = make(name, map_patch=16)
    assert all(type(space) is Box for space in env.observation_space.values())


def test_spaces_are_each_environments_own():
    one, other = make("sonarbed/Explore-v1"), make("sonarbed/Explore-v1")
    one.action_space.seed(1)
    expected = [one.action_space.sample().tolist() for _ in range(2)]
    one.action_space.seed(1)
    first = one.action_space.sample().tolist()
    other.action_space.seed(1)
    assert [first, one.action_space.sample().tolist()] == expected


@pytest.mark.parametrize("height_width", ["office", "corridor", "thesis-exp1"])
def test_frames_have_even_sides(height_width):
    env = gymnasium.make("sonarbed/Navigate-v1", world=height_width, render_mode="rgb_array")
    env.reset(seed=0)
    assert [side % 2 for side in env.render().shape[:2]] == [0, 0]


@pytest.mark.parametrize("rooms", [["corridor", "l-shape"], ["l-shape", "corridor", "office"]])
def test_frames_have_one_size_for_all_rooms(name, rooms):
    env = make(name, world=rooms, render_mode="rgb_array")
    pictured = gymnasium.wrappers.AddRenderObservation(env)
    shapes = set()
    # Also in a room that is not the environment's.
    for seed, options in enumerate([{}, {}, {}, {}, {"world": "office"}, {"world": rooms[0]}]):
        frame, _ = pictured.reset(seed=seed, options=options)
        assert pictured.observation_space.contains(frame)
        shapes.add(frame.shape)
    assert len(shapes) == 1


def test_the_order_of_a_set_counts_for_nothing():
    told = []
    for hashes in "1234":
        code = (
            "import gymnasium, sim; env = gymnasium.make('sonarbed/Navigate-v1', world={'office',"
            "'clutter', 'l-shape'}, randomisation={'materials': {'wood', 'metal', 'foam'}});"
            "print([env.reset(seed=i)[0]['range'].tolist() for i in range(6)])"
        )
        told.append(
            subprocess.run(
                [sys.executable, "-c", code],
                check=True, capture_output=True, text=True,
                env={**os.environ, "PYTHONHASHSEED": hashes},
            ).stdout
        )  # fmt: skip
    assert len(set(told)) == 1


@pytest.mark.parametrize(
    ("seed", "message"),
    [
        (1.5, "seed must be a whole number, got 1.5"),
        ("1", "seed must be a number, got '1'"),
        (True, "seed must be a number, got True"),
        (-1, "seed must be >= 0, got -1"),
    ],
)
def test_bad_seeds_are_refused(seed, message):
    with pytest.raises(InputError, match=message):
        sim.envs.NavigateEnv().reset(seed=seed)


def test_a_seed_may_be_numpys():
    env = sim.envs.NavigateEnv()
    pose = env.reset(seed=np.uint16(3))[1]["true_pose"]
    assert pose.tolist() == env.reset(seed=3)[1]["true_pose"].tolist()


def test_a_sonar_without_noise_cannot_be_randomised():
    env = make("sonarbed/Explore-v1", sonar="webots", randomisation={"noise": (1, 2)})
    with pytest.raises(InputError, match="'webots' has neither noise nor air"):
        env.reset(seed=0)


def robot_at(frame):
    """Return the mean pixel (x, y) of the robot's body in the left panel."""
    body = [int(ROBOT_COLOURS[0][i : i + 2], 16) for i in (1, 3, 5)]
    found = (frame == body).all(axis=2)
    rows, cols = np.nonzero(found)
    return cols.mean(), rows.mean()


def test_the_robots_pixels_move_as_the_robot_does():
    env = sim.envs.FollowWallEnv(world="office", start=(2.0, 3.0, 0.0), render_mode="rgb_array")
    env.reset(seed=0)
    before, pose_before = env.render(), env.batch.states["true_pose"][0].copy()
    for _ in range(20):
        env.step(np.array([0.6, 0.0], np.float32))
    after, pose_after = env.render(), env.batch.states["true_pose"][0].copy()
    assert before.shape == after.shape
    moved_px = np.subtract(robot_at(after), robot_at(before))
    moved_m = (pose_after - pose_before)[:2]
    assert moved_m[0] > 0.4
    px_per_m = moved_px[0] / moved_m[0]
    assert 40 < px_per_m < 120
    assert moved_px[1] == pytest.approx(-moved_m[1] * px_per_m, abs=1.5)


def test_rendering_changes_nothing(name):
    drawn = make(name, render_mode="rgb_array", map_patch=20)
    blind = make(name, map_patch=20)
    with_frames = []
    drawn.action_space.seed(0)
    with_frames.append(drawn.reset(seed=1))
    for _ in range(20):
        frame = drawn.render()
        assert (frame.dtype, frame.ndim, frame.shape[2]) == (np.uint8, 3, 3)
        with_frames.append(drawn.step(drawn.action_space.sample()))
        if with_frames[-1][2]:
            with_frames.append(drawn.reset())
    assert flat(with_frames) == flat(roll(blind, 20, seed=1))


def test_a_window_shows_the_frames(monkeypatch):
    pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = make("sonarbed/Explore-v1", render_mode="human")
    # The metadata are the class's: what a test changes of them must not stay.
    monkeypatch.setitem(env.metadata, "render_fps", 1000)
    env.reset(seed=0)
    env.step(env.action_space.sample())
    assert env.render() is None
    env.close()


def test_the_map_so_far_is_there_for_who_asks():
    env = make("sonarbed/Explore-v1").unwrapped
    env.reset(seed=0)
    assert (env.occupancy_map.probability != 0.5).any()
    without = make("sonarbed/Navigate-v1").unwrapped
    without.reset(seed=0)
    assert without.occupancy_map is None


def test_an_environments_arguments_pickle():
    spec = gymnasium.spec("sonarbed/Explore-v1")
    assert pickle.loads(pickle.dumps(spec)).id == "sonarbed/Explore-v1"
