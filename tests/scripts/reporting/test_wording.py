"""Words and clauses that follow numbers."""

from sonarbed.reporting.statistics import Estimate
from sonarbed.reporting.wording import cause_name, verdicts, word
from sonarmap import Cause

BY_ROOM = {
    "hall": Estimate(0.2, 0.1, 0.3),
    "cell": Estimate(-0.2, -0.3, -0.1),
    "attic": Estimate(0.1, -0.1, 0.3),
}


def test_words_follow_the_interval_and_what_is_better():
    assert [word(e, 1) for e in BY_ROOM.values()] == ["better", "worse", "undecided"]
    assert [word(e, -1) for e in BY_ROOM.values()] == ["worse", "better", "undecided"]


def test_verdicts_name_the_rooms():
    clauses = verdicts(BY_ROOM, -1, 1)
    assert clauses == (
        "better in 1 of 3 (cell -0.2), worse in 1 of 3 (hall +0.2), "
        "undecided in 1 of 3 (attic +0.1)"
    )
    one = verdicts({"hall": BY_ROOM["hall"]}, 1, words=("up", "down", "level"))
    assert one == "up in 1 of 1 (hall +0.20)"


def test_causes_have_names_for_people():
    assert cause_name(Cause.OFF_AXIS) == "off axis"
