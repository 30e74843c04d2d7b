"""Searches that resume, and studies that are refused."""

import shutil
from dataclasses import replace

import numpy as np
import optuna
import pytest
from searches import ignore, make_drives, search_in

from sonarbed.studies.tuning import search as searching
from sonarbed.studies.tuning import settings as settings_module
from sonarbed.studies.tuning.scoring import score_candidate
from sonarbed.studies.tuning.search import find
from sonarbed.studies.tuning.space import RING, thesis_points
from sonarmap.errors import InputError
from sonarmap.goodness import thesis_parameter_sets

pytestmark = pytest.mark.engine


@pytest.fixture(scope="module")
def drives(tmp_path_factory):
    """The folder of the drives of `SMALL`, simulated once."""
    return make_drives(tmp_path_factory.mktemp("drives"))


@pytest.fixture
def folder(drives, tmp_path):
    """A folder with the drives and no study."""
    shutil.copytree(drives, tmp_path / "out" / "logs")
    return tmp_path / "out"


def points(found):
    return [(trial.candidate, trial.score) for trial in found.trials]


@pytest.mark.parametrize("sampler", ["tpe", "nsga2", "grid"])
def test_an_interrupted_search_ends_as_one_that_was_not(folder, sampler, monkeypatch):
    monkeypatch.setattr(searching, "_POPULATION", 4)  # so that NSGA-II breeds in so few trials
    search = search_in(folder, sampler=sampler)

    def stop_at_four(label, done, total):
        if (label, done) == ("trials", 4):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        find(search, trials=12, on_progress=stop_at_four)
    first = find(search, trials=4, on_progress=ignore)  # nothing is left to do
    assert len(first.trials) == 4
    resumed = find(search, trials=12, on_progress=ignore)
    assert len(resumed.trials) == 12
    assert points(resumed)[:4] == points(first)
    # Children of NSGA-II may repeat a parent; nothing else repeats.
    assert len(set(points(resumed))) >= (9 if sampler == "nsga2" else 12)
    assert resumed.best.score == max(trial.score for trial in resumed.trials)

    whole = find(replace(search, study_name="whole"), trials=12, on_progress=ignore)
    assert points(whole) == points(resumed)


def test_the_seed_decides(folder):
    def of(name, seed):
        search = replace(search_in(folder, seed=seed), study_name=name)
        return points(find(search, trials=4, on_progress=ignore))

    assert of("a", 3) == of("b", 3)
    assert of("c", 4) != of("a", 3)


@pytest.mark.parametrize("sampler", ["nsga2", "tpe", "cmaes"])
def test_every_sampler_searches_everything(folder, sampler, monkeypatch):
    monkeypatch.setattr(searching, "_POPULATION", 3)
    search = search_in(folder, sampler=sampler, target="both")
    found = find(search, trials=8, on_progress=ignore)
    assert len(set(points(found))) == 8
    best = found.best
    again = [
        score_candidate(best.candidate, search.drives.scorable(spec), "skill")
        for spec in search.settings.drives(["thesis-exp1"])
    ]
    assert best.score == pytest.approx(np.mean(again), abs=1e-12)


@pytest.mark.parametrize(
    ("score", "pick"), [("brier", min), ("f1_10_cm", max), ("average_precision", max)]
)
def test_the_best_is_the_best_of_its_score(folder, score, pick):
    found = find(search_in(folder, score=score), trials=4, on_progress=ignore)
    assert found.best.score == pick(trial.score for trial in found.trials)


def test_two_processes_never_make_a_set_of_the_grid_twice(folder):
    search = search_in(folder, sampler="grid")
    seen = []
    found = find(search, trials=6, jobs=2, on_progress=lambda *told: seen.append(told))
    assert seen[-1] == ("trials", 6, 6)
    found = find(search, trials=9, on_progress=ignore)
    models = [trial.candidate.pipeline.method.sensor_model(RING) for trial in found.trials]
    assert len(set(models)) == len(models) == 9
    assert set(models) <= set(thesis_parameter_sets())


@pytest.mark.parametrize("others", [4, 5])
@pytest.mark.parametrize("sampler", ["tpe", "grid"])
def test_what_others_have_made_meanwhile_is_not_made_again(folder, sampler, others, monkeypatch):
    search, made = search_in(folder, sampler=sampler), []

    def joined(*arguments):
        # In the middle of the first trial somebody else makes all but that one, or all.
        made.append(arguments)
        if len(made) == 1:
            other = replace(search, seed=1)
            study = searching.connect(other.kept)
            for number in range(1, 1 + others):
                point = tuple(thesis_points()[number].items()) if sampler == "grid" else None
                searching._one_trial(searching._Task(other, number, 5, point))
            assert len(searching._finished(study)) == others
        return score_candidate(*arguments)

    monkeypatch.setattr(searching, "score_candidate", joined)
    assert len(find(search, trials=5, on_progress=ignore).trials) == 5


def test_a_study_of_another_version_is_refused(folder, monkeypatch):
    find(search_in(folder), trials=1, on_progress=ignore)
    monkeypatch.setattr(settings_module, "FORMAT_VERSION", 3)
    with pytest.raises(InputError, match="was made with format 2, asked for 3: choose another"):
        find(search_in(folder), trials=1, on_progress=ignore)


def test_a_study_of_somebody_else_is_refused(folder):
    search = search_in(folder)
    study = optuna.create_study(storage=search.storage, study_name="tune")
    study.ask()
    with pytest.raises(InputError, match="was not made by sonarbed"):
        find(search, trials=1, on_progress=ignore)
