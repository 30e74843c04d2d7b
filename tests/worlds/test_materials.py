import math

import pytest

import worlds
from sonarmap import InputError

SMOOTH = ["glass", "metal", "whiteboard", "drywall", "wood", "cardboard", "smooth-cardboard"]
ROUGH = ["plaster", "brick", "carpet", "books", "curtain", "foam"]
# A surface is a mirror below an eighth of the wavelength, 6.95 mm at 49.4 kHz (Rayleigh).
RAYLEIGH_M = 6.95e-3 / 8


def test_presets_are_named_by_their_keys():
    assert set(worlds.MATERIALS) == {*SMOOTH, *ROUGH}
    assert all(name == material.name for name, material in worlds.MATERIALS.items())


def test_presets_cannot_be_changed():
    with pytest.raises(TypeError):
        worlds.MATERIALS["glass"] = worlds.MATERIALS["foam"]


def test_mirrors_are_smoother_than_rayleighs_limit_and_scatterers_rougher():
    assert max(worlds.MATERIALS[name].roughness_m for name in SMOOTH) < RAYLEIGH_M
    assert min(worlds.MATERIALS[name].roughness_m for name in ROUGH) > RAYLEIGH_M


def test_rough_surfaces_return_sound_from_farther_aside():
    critical = {name: m.critical_incidence_rad for name, m in worlds.MATERIALS.items()}
    assert max(critical[name] for name in SMOOTH) < min(critical[name] for name in ROUGH)


def test_rough_surfaces_scatter_more():
    floor_db = {name: m.diffuse_floor_db for name, m in worlds.MATERIALS.items()}
    assert max(floor_db[name] for name in SMOOTH) <= -40
    assert min(floor_db[name] for name in ROUGH) >= -35


def test_a_loss_in_decibels_becomes_a_share_of_the_amplitude():
    assert worlds.MATERIALS["smooth-cardboard"].reflectivity == pytest.approx(0.8913, abs=1e-4)
    assert worlds.MATERIALS["foam"].reflectivity < 0.2 < worlds.MATERIALS["curtain"].reflectivity


@pytest.mark.parametrize(
    ("values", "rule"),
    [
        ((0.0, 1.0, 0.0), r"critical_incidence_rad must be within \(0, pi/2\], got 0.0"),
        ((1.6, 1.0, 0.0), r"critical_incidence_rad must be within \(0, pi/2\], got 1.6"),
        ((math.nan, 1.0, 0.0), r"critical_incidence_rad must be within"),
        ((1.0, 1.1, 0.0), r"reflectivity must be within \[0, 1\], got 1.1"),
        ((1.0, math.nan, 0.0), r"reflectivity must be within"),
        ((1.0, 1.0, -1e-3), r"roughness_m must be >= 0, got -0.001"),
        ((1.0, 1.0, 0.0, 0.1), r"diffuse_floor_db must be within \[-100, 0\], got 0.1"),
        ((1.0, 1.0, 0.0, -math.inf), r"diffuse_floor_db must be within"),
    ],
)
def test_impossible_materials_are_refused(values, rule):
    with pytest.raises(InputError, match=rule):
        worlds.Material("stuff", *values)
