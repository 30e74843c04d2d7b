"""Specs: what they must be, with the path of the key in every complaint."""

import random
from itertools import islice
from pathlib import Path

import pytest
from tiny_datasets import as_toml, tiny, tiny_spec

from sim.datasets import parse_spec, read_spec
from sim.datasets.plan import plan_of
from sonarmap.errors import InputError

HERE = Path()

BIG = """
half_angle_deg = 15
range_min_m = 0.1
range_max_m = 5
[[sonar]]
x_m = 0.5
y_m = 0
heading_deg = 0
"""

REFUSED = [
    # Keys.
    ({"nmae": "x"}, "nmae: unknown key; did you mean 'name'?"),
    ({"logs__scnas": 3}, "logs.scnas: unknown key; did you mean 'scans'?"),
    ({"rooms__file": ["x"]}, "rooms.file: unknown key; did you mean 'files'?"),
    ({"splits__tset": 0.1}, "splits.tset: unknown key; did you mean 'test'?"),
    (
        {"logs__receiver": {"gain_shar": 3}, "logs__sonar": "physical"},
        "logs.receiver.gain_shar: unknown key; did you mean 'gain_share'?",
    ),
    (
        {"logs__driver_parameters": {"distance": 1}},
        "logs.driver_parameters.distance: unknown key; did you mean 'distance_m'?",
    ),
    ({"logs__air": {"temp_c": 1}}, "logs.air.temp_c: unknown key"),
    ({"rooms__generate": [{"seeds": 3}]}, "rooms.generate[0].style: is missing"),
    # Values.
    ({"name": "a/b"}, "name: String must match pattern"),
    ({"seed": -1}, "seed: must be greater than or equal to 0, got -1"),
    ({"logs__seeds": 0}, 'logs.seeds: must be how many, or "FROM:TO"'),
    ({"logs__seeds": "5:2"}, "logs.seeds: must be how many"),
    ({"logs__seeds": 10**12}, "logs.seeds: must be at most 10000000 seeds"),
    ({"logs__scans": 0}, "logs.scans: must be 1 to 1000000, got 0"),
    ({"logs__scans": 2.5}, "logs.scans: must be a whole number, got 2.5"),
    ({"logs__scans": {"uniform": [0, 5]}}, "logs.scans: must be 1 to 1000000, got 0"),
    ({"logs__start": "there"}, "logs.start: must be 'room' or 'anywhere', got 'there'"),
    ({"logs__packets": 1}, "logs.packets: must be true or false, got 1"),
    ({"splits__test": 1.5}, "splits.test: must be less than or equal to 1, got 1.5"),
    (
        {"splits__test": 0.6, "splits__validation": 0.6},
        "splits: validation and test must be at most 1 together, got 0.6 and 0.6",
    ),
    ({"splits__rooms": {"offcie": "test"}}, "splits.rooms.offcie: unknown room; did you mean"),
    ({"splits__rooms": {"office": "tset"}}, "splits.rooms.office: must be 'train', 'validation'"),
    # Names.
    ({"rooms": {}}, "rooms: must have names, files or generate"),
    ({"rooms": {"names": ["offcie"]}}, "rooms.names[0]: unknown room 'offcie'; did you mean 'off"),
    ({"rooms": {"files": ["x.toml"]}}, "rooms.files[0]: 'x.toml' is no file"),
    ({"rooms": {"files": ["x/*.toml"]}}, "rooms.files[0]: 'x/*.toml' is no file"),
    ({"rooms": {"files": ["a\0b"]}}, "rooms.files[0]: "),
    ({"logs__driver": "wonder"}, "logs.driver: driver 'wonder' is unknown; did you mean 'wander'?"),
    ({"logs__sonar": ["aria", "x:y"]}, "logs.sonar: sonar 'x:y' cannot be imported"),
    ({"logs__engine": "bulet"}, "logs.engine: engine 'bulet' is unknown; did you mean 'bullet'?"),
    ({"logs__ring": "amigo"}, "logs.ring: ring 'amigo' is unknown; did you mean 'amigobot'?"),
    ({"logs__ring": "gone.toml"}, "gone.toml: no such file"),
    (
        {"logs__ring": {"choice": ["amigobot", "pioneer3dx"]}},
        "logs.ring: ring 'pioneer3dx' is larger than the robot: sonar",
    ),
    # What a part refuses, by name or in the extremes of what is drawn.
    (
        {"logs__driver_parameters": {"speed_mps": {"uniform": [-1, 1]}}},
        "logs.driver_parameters.speed_mps: must be > 0, got -1",
    ),
    ({"logs__air": {"temperature_c": [20, 99]}}, "logs.air.temperature_c: must be within"),
    ({"logs__odometry": {"slip_std_m": -1}}, "logs.odometry.slip_std_m: must be >= 0, got -1"),
    (
        {"logs__sonar_parameters": {"scan_period_s": 0.0123}},
        "logs.sonar_parameters.scan_period_s: must be",
    ),
    ({"logs__sonar_parameters": {"rays": 4}}, "logs.sonar_parameters.rays: must be odd"),
    ({"logs__receiver": {"gain_share": 0.5}}, "logs.receiver: none of the sonars has a receiver"),
    ({"logs__status_packets": {"period_s": 0.2}}, "logs.status_packets: needs packets = true"),
    ({"logs__sonar": "webots"}, "logs.air.temperature_c: sonar 'webots' has neither noise nor air"),
]


@pytest.mark.parametrize(("changes", "message"), REFUSED)
def test_bad_specs_are_refused_with_the_place(changes, message):
    with pytest.raises(InputError) as caught:
        plan_of(tiny_spec(**changes), HERE)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_complaint_begins_with_the_file(tmp_path):
    path = tmp_path / "spec.toml"
    path.write_text("name = 3\n[rooms]\nnames = ['office']")
    with pytest.raises(InputError, match=r"spec.toml: name: must be a valid string, got 3"):
        read_spec(path)
    path.write_text("name = ")
    with pytest.raises(InputError, match=r"spec\.toml: is not TOML"):
        read_spec(path)
    path.write_text(as_toml(tiny()))
    assert read_spec(path) == tiny_spec()


def test_a_ring_of_ones_own(tmp_path):
    ring = tmp_path / "ring.toml"
    ring.write_text(BIG)
    with pytest.raises(InputError, match=r"is larger than the robot: sonar 0 sits 0\.5 m"):
        plan_of(tiny_spec(logs__ring="ring.toml"), tmp_path)
    ring.write_text(BIG.replace("x_m = 0.5", "x_m = 0.1"))
    for sonar in ("aria", "physical"):  # one that fires all at once, one that fires in turn
        plan = plan_of(tiny_spec(logs__ring="ring.toml", logs__sonar=sonar), tmp_path)
        job = next(plan.logs_of(next(plan.rooms())))
        assert (job.ring.name, len(job.ring)) == ("ring", 1)
    ring.write_text(BIG.replace("y_m", "ym"))
    with pytest.raises(InputError, match=r"sonar.0..ym: unknown key; did you mean 'y_m'"):
        plan_of(tiny_spec(logs__ring="ring.toml"), tmp_path)


def test_lists_make_every_combination_and_distributions_are_drawn():
    plan = plan_of(tiny_spec(logs__start=["room", "anywhere"], logs__scans=[3, 4, 5]), HERE)
    jobs = [job for room in plan.rooms() for job in plan.logs_of(room)]
    assert len(jobs) == plan.log_count == 3 * 2 * (2 * 2 * 3)
    assert len({job.outputs[0] for job in jobs}) == len(jobs)
    assert len({job.seed for job in jobs}) == len(jobs)
    drawn = [dict(job.settings)["air.temperature_c"] for job in jobs]
    assert len(set(drawn)) == len(jobs)
    chosen = [{k: v for k, v in job.settings if "." not in k} for job in jobs[:24]]
    assert len({tuple(each.values()) for each in chosen}) == 12
    again = plan_of(tiny_spec(logs__start=["room", "anywhere"], logs__scans=[3, 4, 5]), HERE)
    assert [job.digest for room in again.rooms() for job in again.logs_of(room)] == [
        job.digest for job in jobs
    ]


def test_what_a_room_gives_does_not_depend_on_other_rooms():
    def logs(names):
        plan = plan_of(tiny_spec(rooms={"names": names}, splits={"test": 0.5}), HERE)
        rooms = list(plan.rooms())
        return {r.name: (plan.split_of(r), [j.digest for j in plan.logs_of(r)]) for r in rooms}

    few, many = logs(["office", "corridor"]), logs(["*"])
    assert len(many) >= 8
    assert {name: many[name] for name in few} == few


def test_splits_have_their_shares_and_copies_of_a_room_fall_together(tmp_path):
    source = Path(plan_of(tiny_spec(), HERE).rooms().__next__().path).read_text()
    for i in range(400):
        (tmp_path / f"r{i}.toml").write_text(f"# {i}\n{source}")
    (tmp_path / "copy-of-r0.toml").write_text((tmp_path / "r0.toml").read_text())
    spec = tiny_spec(rooms={"files": ["*.toml"]}, splits={"test": 0.2, "validation": 0.1})
    plan = plan_of(spec, tmp_path)
    rooms = list(plan.rooms())
    # The copy is the same room: it is taken once.
    assert len(rooms) == plan.room_count == 400
    splits = [plan.split_of(room) for room in rooms]
    shares = [splits.count(name) / 400 for name in ("train", "validation", "test")]
    assert shares == pytest.approx([0.7, 0.1, 0.2], abs=0.06)
    other = plan_of(spec.model_copy(update={"seed": 1}), tmp_path)
    assert [other.split_of(room) for room in rooms] != splits


def test_rooms_of_one_name_are_told_apart(tmp_path):
    text = Path(next(plan_of(tiny_spec(), HERE).rooms()).path).read_text()
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "my room.toml").write_text(f"# {folder}\n{text}")
    spec = tiny_spec(rooms={"files": ["*/my room.toml"]}, splits={})
    first, second = plan_of(spec, tmp_path).rooms()
    assert first.name == "my_room"
    assert second.name == f"my_room-{second.key[:6]}"


WORDS = [
    "",
    "x",
    "office",
    "route",
    "physical",
    "a.toml",
    "*",
    "../*",
    "0:3",
    "1:0",
    "\0",
    "é" * 50,
]
NUMBERS = [0, 1, -1, 3, 1e300, -1e-300, float("nan"), float("inf"), 2**70, 0.5]


def mutated(tables, rng):
    """Return tables with something in them changed."""

    def places(value, path=()):
        yield path
        if isinstance(value, dict):
            for key in value:
                yield from places(value[key], (*path, key))
        elif isinstance(value, list):
            for i in range(len(value)):
                yield from places(value[i], (*path, i))

    def anything(depth=0):
        kind = rng.randrange(8 if depth < 2 else 5)
        match kind:
            case 0 | 1:
                return rng.choice(NUMBERS)
            case 2 | 3:
                return rng.choice(WORDS)
            case 4:
                return rng.random() < 0.5
            case 5:
                return [anything(depth + 1) for _ in range(rng.randrange(4))]
            case 6:
                name = rng.choice(["uniform", "normal", "log_uniform", "choice", "within"])
                return {name: [anything(2) for _ in range(rng.randrange(1, 4))]}
            case _:
                keys = rng.sample(["name", "style", "seeds", "scans", "x", "rays"], 2)
                return {key: anything(depth + 1) for key in keys}

    path = rng.choice(list(places(tables))[1:])
    holder = tables
    for part in path[:-1]:
        holder = holder[part]
    key = path[-1]
    match rng.randrange(4):
        case 0:
            del holder[key]
        case 1 if isinstance(key, str):
            letters = list(key)
            letters.insert(rng.randrange(len(letters) + 1), rng.choice("abcxyz_"))
            holder["".join(letters)] = holder.pop(key)
        case _:
            holder[key] = anything()
    return tables


FULL = {
    "logs__sonar": ["physical", "aria"],
    "logs__ring": {"choice": ["amigobot", "amigobot-aria"]},
    "logs__receiver": {"dynamic_range_db": {"normal": [48, 2]}, "gain_share": 0.5},
    "logs__transducer": {"radius_m": {"uniform": [0.015, 0.02]}},
    "logs__odometry": {"slip_std_m": {"log_uniform": [0.001, 0.01]}, "ticks_per_turn": 500},
    "logs__driver_parameters": {"speed_mps": {"uniform": [0.1, 0.3]}},
    "logs__packets": [True, False],
    "logs__status_packets": {"period_s": 0.1},
    "rooms__files": ["*.toml"],
}


def test_mutated_specs_are_planned_or_refused_in_one_line(tmp_path):
    room = Path(next(plan_of(tiny_spec(), HERE).rooms()).path)
    (tmp_path / "a.toml").write_text(room.read_text())
    rng = random.Random(20261126)
    refused = []
    for _ in range(300):
        tables = tiny(**FULL)
        for _ in range(rng.randrange(1, 4)):
            tables = mutated(tables, rng)
        try:
            plan = plan_of(parse_spec(tables), tmp_path)
            assert plan.log_count > 0
            for found in islice(plan.rooms(), 2):
                for job in islice(plan.logs_of(found), 3):
                    assert job.outputs[0].isprintable()
            assert plan.identity
        except InputError as error:
            refused.append(str(error))
    assert 100 < len(refused) < 300
    assert not any("\n" in line for line in refused)
