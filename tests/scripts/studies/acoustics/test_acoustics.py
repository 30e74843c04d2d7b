"""The page on acoustics: its numbers against arithmetic, and the page itself."""

import math
import re

import numpy as np
import pytest

from sim import Piston
from sim.sonar import presets as sonars
from sonarbed.cli import main
from sonarbed.studies import acoustics
from sonarbed.studies.acoustics import (
    beam,
    causes,
    crosstalk,
    dropout,
    ghost,
    reality,
    theory,
)
from sonarbed.studies.acoustics.regions import sweeps, targets

PHYSICAL = sonars.preset("physical")
STEP_DEG = 0.5


def swept(target, sonar=None):
    axis = np.radians(np.arange(-180, 180, STEP_DEG))
    sonar = theory.sharp(PHYSICAL) if sonar is None else sonar
    heard = sweeps.sweep(sonar, target.world, (-target.distance_m, 0.0), axis)
    return axis, heard.range_m


# Regions of constant depth.


@pytest.mark.parametrize("number", range(6))
def test_single_things_are_read_at_the_distance_of_theory(number):
    target = targets.targets(PHYSICAL)[number]
    axis, read_m = swept(target)
    deviation = sweeps.compared(read_m, theory.range_m(PHYSICAL, target.loci, axis))
    assert deviation.largest_m < 1e-6
    # Steps that fall beside the end of an arc may disagree by rounding.
    assert deviation.agreeing > 0.995
    own = np.isclose(read_m, [2.0, 2.0, 1.0, 1.0, 1.0, 1.0][number], atol=1e-3)
    assert own[np.argmin(np.abs(axis))]
    assert own.any() == np.isfinite(read_m).any()


def test_width_of_a_planes_arc_is_that_of_beam_and_level():
    # At 2 m spreading takes 6.02 dB and two more metres of air 1.64 each; 30 % of it stays lost.
    loss_db = 20 * math.log10(2) + 2 * PHYSICAL.air.absorption_db_per_m(49_400)
    over_db = 48 - 0.3 * loss_db
    assert theory.plane_over_db(PHYSICAL, 2.0) == pytest.approx(over_db)
    (begin, end), *side = theory.heard_spans_rad(PHYSICAL, over_db)
    assert begin == 0
    assert 2 * Piston().level_db(end) == pytest.approx(-over_db, abs=0.1)
    assert len(side) == 1
    axis, read_m = swept(targets.targets(PHYSICAL)[0])
    heard = np.degrees(axis[np.isfinite(read_m)])
    assert heard.max() == pytest.approx(math.degrees(side[0][1]), abs=STEP_DEG)


def test_side_walls_of_a_corner_are_read_where_they_are_nearest():
    axis, read_m = swept(targets.targets(PHYSICAL)[1])
    beside = np.isclose(np.abs(np.degrees(axis)), 45)
    assert read_m[beside] == pytest.approx([math.sqrt(2)] * 2, abs=1e-6)


def test_pillars_are_quieter_than_planes_by_theory():
    assert theory.pillar_db(0.05, 1.0) == pytest.approx(-13.2, abs=0.1)
    assert theory.pillar_db(0.02, 2.0) == pytest.approx(-20.0, abs=0.1)


def test_comparison_counts_what_only_one_side_hears():
    inf = math.inf
    deviation = sweeps.compared(np.array([1, inf, 1, 2.1]), np.array([1.02, inf, inf, 2.1]))
    assert deviation == sweeps.Deviation(pytest.approx(0.02), 0.75)
    assert math.isnan(sweeps.compared(np.array([inf]), np.array([1.0])).largest_m)


# The beam.


def test_beams_angles_are_those_of_a_piston():
    piston = PHYSICAL.piston
    rule = math.asin(0.61 * piston.wavelength_m / piston.radius_m)
    assert beam.first_null_rad(piston) == pytest.approx(rule, abs=math.radians(0.05))
    # 2 J1(x) / x is 1 / sqrt(2) at x = 1.616.
    ka = 2 * math.pi / piston.wavelength_m * piston.radius_m
    half_power_db = 10 * math.log10(2)
    assert beam.half_angle_rad(piston, half_power_db) == pytest.approx(
        math.asin(1.616 / ka), abs=1e-4
    )


# Dropout.


def test_56_db_hear_a_mirror_up_to_42_degrees_with_dead_bands_between():
    loud = PHYSICAL.receiver.__class__(dynamic_range_db=56.0, gain_share=1.0)
    incidence_deg = np.arange(0, 60, 0.25)
    answer = dropout.answers(
        PHYSICAL.replace(receiver=loud), dropout.PERFECT, 2.0, np.radians(incidence_deg)
    )
    assert incidence_deg[answer != dropout.LOST].max() == pytest.approx(42, abs=2)
    bands = np.array(dropout.dead_bands_deg(incidence_deg, answer))
    assert bands.ravel() == pytest.approx([12.25, 13.25, 22.5, 25.75, 32.75, 41.5], abs=0.5)


def test_rough_walls_scatter_where_mirrors_are_silent():
    at_40 = np.radians([0.0, 40.0])
    glass, brick = (dropout.answers(PHYSICAL, name, 1.0, at_40) for name in ("glass", "brick"))
    assert glass.tolist() == [dropout.MIRRORED, dropout.LOST]
    assert brick.tolist() == [dropout.MIRRORED, dropout.SCATTERED]


def test_dead_bands_lie_between_heard_ones():
    answer = np.array([1, 1, 0, 0, 2, 0, 0])
    assert dropout.dead_bands_deg(np.arange(7.0), answer) == [(2.0, 3.0)]


# The ghost.


@pytest.mark.parametrize(("mirrors", "slant_deg"), [(1, 30), (1, 45), (2, 40), (2, 45)])
def test_ghost_is_as_far_as_the_image_source(mirrors, slant_deg):
    corridor = ghost.Corridor(math.radians(slant_deg), mirrors)
    # Unfolded, the axis is one straight line: every leg up to a wall, and the last metre.
    up_m = 0.8 + 1.6 * (mirrors - 1)
    expected_m = up_m / math.sin(math.radians(slant_deg)) + 1.0
    assert corridor.ghost_m == pytest.approx(expected_m)
    sonar = theory.sharp(PHYSICAL.replace(max_bounces=mirrors))
    range_m, met = corridor.reading(sonar)
    assert range_m == pytest.approx(expected_m, abs=1e-4)
    assert met == mirrors


# The page.


@pytest.mark.engine
def test_page_shows_every_part(tmp_path, run, monkeypatch):
    monkeypatch.setattr(crosstalk, "SECONDS", (1.0, 1.0))
    monkeypatch.setattr(causes, "SECONDS", (1.0, 1.0))
    monkeypatch.setattr(reality, "SECONDS", (2.0, 2.0))
    monkeypatch.setattr(causes, "ROOMS", ("thesis-exp1", "corridor"))
    out = tmp_path / "page"
    told = run(["acoustics", "--quick", "--jobs", "1", "--out", out])
    assert told == f"Page: {out / 'report.html'}, {out / 'report.md'}\n"
    html, markdown = (
        (out / name).read_text(encoding="utf-8") for name in ("report.html", "report.md")
    )
    assert not re.search(r"https?:|<script|\.\.\.|\bnan\b", html)
    assert "The thesis" not in html
    assert html.count("<img") == 9
    assert "A quick run" in html
    for part in acoustics.PARTS:
        assert f'id="{part}"' in html
        assert (out / part / "section.json").is_file()
    links = re.findall(r"\]\(([^)]+)\)", markdown)
    assert {link.split("/")[0] for link in links} == set(acoustics.PARTS)
    assert all((out / link).is_file() for link in links)
    # A report of the thesis does not get into its folder.
    err = run(["thesis", "--quick", "--sonar", "physical", "--out", out], code=2)
    assert "holds a report with report 'acoustics', asked for 'thesis'" in err


def test_hallway_is_as_silent_as_the_real_one():
    shares = reality.shares_of(reality.as_real(PHYSICAL, 83.0, seed=0).simulate())
    real = reality.REAL
    assert shares.lost == pytest.approx(real.lost, abs=0.04)
    assert min(shares.lost_by_sonar) == pytest.approx(min(real.lost_by_sonar), abs=0.06)
    # The real robot's sonar at +7.5 degrees hears far less than its twin at -7.5; ours are alike.
    assert max(shares.lost_by_sonar) == pytest.approx(0.65, abs=0.08)
    assert np.mean(shares.lost_by_sonar[3:5]) == pytest.approx(
        np.mean(real.lost_by_sonar[3:5]), abs=0.12
    )
    assert shares.repeated == pytest.approx(real.repeated, abs=0.05)
    assert min(shares.repeated_by_sonar) == pytest.approx(min(real.repeated_by_sonar), abs=0.09)
    assert max(shares.repeated_by_sonar) == pytest.approx(max(real.repeated_by_sonar), abs=0.09)


def test_sonar_without_a_beam_is_refused():
    with pytest.raises(Exception, match="sonar 'thesis' has no beam to compare with theory"):
        theory.physical("thesis")


def test_bad_jobs_end_before_the_folder_is_made(tmp_path, capsys):
    assert main(["acoustics", "--out", str(tmp_path / "new"), "--jobs", "0"]) == 2
    assert capsys.readouterr().err == "sonarbed: --jobs must be >= 1, got 0\n"
    assert not (tmp_path / "new").exists()
