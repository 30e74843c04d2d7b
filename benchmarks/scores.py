"""Every score of maps that say something else: python benchmarks/scores.py [PNG] draws them."""

import sys
from pathlib import Path

import numpy as np

import sonarmap as sm
import worlds
from sonarbed.reporting.drawing import figure_with, save

ROOM, SIZE_M = "l-shape", 0.1
ROWS = {
    "skill": "skill",
    "Map Score, bit": "map_score",
    "average precision": "average_precision",
    "the same within 1 cell": "tolerant_average_precision",
    "calibration error": "calibration_error",
    "F1 within 1 cell": "f1_1_cell",
    "F1 within 10 cm": "f1_10_cm",
    "F1 within 20 cm": "f1_20_cm",
    "coverage": "coverage",
    "false-free area, m²": "false_free_m2",
    "phantom area, m²": "phantom_m2",
    "walls without a cell, m": "wall_gap_m",
    "thickness, m": "thickness_m",
    "map to truth, m": "map_to_truth_m",
    "truth to map, m": "truth_to_map_m",
    "Baddeley's distance, m": "baddeley_m",
    "image dissimilarity, cells": "image_dissimilarity",
}


def main() -> None:
    room = worlds.load(ROOM)
    left, bottom, right, top = room.bounds_m
    frame_m = 3 * SIZE_M  # so that what is shifted stays in the picture
    grid = sm.GridSpec.covering(
        left - frame_m, bottom - frame_m, right + frame_m, top + frame_m, SIZE_M
    )
    truth = worlds.truth(room, grid)
    walls = truth.state == worlds.OCCUPIED
    known = truth.state != worlds.HIDDEN
    perfect = np.where(walls, 0.99, 0.01)
    missing = perfect.copy()
    missing[:, : np.flatnonzero(walls.any(axis=0))[0] + 1] = 0.01
    rng = np.random.default_rng(0)
    blurred = np.clip(perfect + rng.normal(0, 0.3, walls.shape), 0.01, 0.99)
    maps = {
        "the truth": perfect,
        "all free": np.full(walls.shape, 0.01),
        "all occupied": np.full(walls.shape, 0.99),
        "all 0.5": np.full(walls.shape, 0.5),
        "the blank sheet": np.full(walls.shape, walls[known].mean()),
        "shifted by a cell": np.roll(perfect, 1, axis=1),
        "a wall missing": missing,
        "noise upon it": blurred,
    }
    figure, panels = figure_with(2, 4, width=2.6, height=2.6)
    columns, paths = {}, {}
    for axes, (name, p) in zip(panels, maps.items(), strict=True):
        built = sm.OccupancyMap.from_probability(truth.grid, p)
        columns[name] = sm.score_map(built, truth).to_dict()
        paths[name] = sm.score_paths(built, truth).to_dict()
        axes.imshow(np.where(known, p, np.nan), cmap="Greys", vmin=0, vmax=1, origin="lower")
        axes.set(title=name, xticks=[], yticks=[])
    if len(sys.argv) > 1:
        save(figure, Path(sys.argv[1]))
    print("| score | " + " | ".join(maps) + " |")
    print("|---" * (len(maps) + 1) + "|")
    for label, key in ROWS.items():
        print(f"| {label} | " + " | ".join(text(told[key]) for told in columns.values()) + " |")
    for label, key in (("paths that collide", "colliding_share"), ("paths missed", "missed_share")):
        print(f"| {label} | " + " | ".join(text(told[key]) for told in paths.values()) + " |")


def text(value: float | None) -> str:
    return "none" if value is None else f"{value:.2f}"


if __name__ == "__main__":
    main()
