"""`generate`: a style and a seed make a room."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from sonarmap.errors import InputError, positive, whole
from sonarmap.parameters import with_parameters
from worlds.generation.base import Style
from worlds.generation.catalogue import STYLES
from worlds.generation.dice import Dice
from worlds.generation.plan import Plan
from worlds.generation.site import NoRoomError, Site
from worlds.world import World

__all__ = ["ROBOT_RADIUS_M", "generate", "plan", "style", "styles"]

ROBOT_RADIUS_M = 0.18
"""The AmigoBot's, from ARIA."""

# A draw that has no place for what must be there is drawn again, so often at most.
_DRAWS = 50


def styles() -> Mapping[str, type[Style]]:
    """Return all styles by name, those of installed packages included."""
    return STYLES


def style(name: str, **parameters: Any) -> Style:
    """Return the style called `name` with parameters of its own.

    Parameters
    ----------
    name : str
        A name of `styles`, or ``package.module:Name`` of a class of one's own.
    **parameters
        Its parameters, such as ``door_min_m=0.9``.

    Raises
    ------
    InputError
        If there is no such style or parameter, or a parameter breaks its rule.
    """
    found = STYLES.find(name)
    if not (isinstance(found, type) and hasattr(found, "build") and hasattr(found, "name")):
        raise InputError(f"style {name!r} must be a class with a name and build(site)")
    try:
        made: Style = with_parameters(f"style {name!r}", found, parameters)
    except InputError as error:
        text = str(error)
        raise InputError(text if text.startswith("style ") else f"style {name!r}: {text}") from None
    return made


def generate(
    style: str | Style, seed: int, *, robot_radius_m: float = ROBOT_RADIUS_M, **parameters: Any
) -> World:
    """Return the room of a style and a seed.

    Parameters
    ----------
    style : str or Style
        A name of `styles`, ``package.module:Name``, or a style.
    seed : int
        Which room, >= 0. The same style, parameters, radius and seed make the same room on any
        machine.
    robot_radius_m : float
        Radius of the robot that shall drive there: its start and its route keep clear of
        everything by this and the style's margin.
    **parameters
        Parameters of a style that is given by name.

    Raises
    ------
    InputError
        If a name or a number breaks its rule, or no room of these parameters has a place for such
        a robot.

    Examples
    --------
    >>> generate("office", 7).name
    'office-0007'
    """
    return plan(style, seed, robot_radius_m=robot_radius_m, **parameters).world()


def plan(
    style: str | Style, seed: int, *, robot_radius_m: float = ROBOT_RADIUS_M, **parameters: Any
) -> Plan:
    """Return the room of a style and a seed as the tables of its file, see `generate`."""
    seed = whole("seed", seed, least=0)
    radius_m = positive("robot_radius_m", robot_radius_m)
    kind = _style(style, parameters)
    for draw in range(_DRAWS):
        rng = np.random.default_rng([*kind.name.encode(), seed, draw])
        site = Site(Dice(rng), radius_m=radius_m, margin_m=kind.margin_m)
        try:
            # Older versions of GEOS divide by zero within, and numpy notices.
            with np.errstate(divide="ignore", invalid="ignore"):
                title = kind.build(site)
            made = _plan(kind, seed, site, title)
            # The rules of every room: a thing wholly outside, a start inside of something.
            made.world()
        except NoRoomError:
            continue
        return made
    raise InputError(
        f"style {kind.name!r}, seed {seed}: in {_DRAWS} draws no room of these parameters had a "
        f"way for a robot of {radius_m:g} m radius"
    )


def _style(kind: str | Style, parameters: Mapping[str, Any]) -> Style:
    if isinstance(kind, str):
        return style(kind, **parameters)
    if parameters:
        raise InputError(f"parameter {next(iter(parameters))!r}: this style has its own already")
    return kind


def _plan(kind: Style, seed: int, site: Site, title: str) -> Plan:
    (x_m, y_m), *route = site.way_m
    assert site.bounds_m is not None, "a shell gives the bounds"
    x_min, y_min, x_max, y_max = site.bounds_m
    settings = {each.name: getattr(kind, each.name) for each in dataclasses.fields(kind)}
    defaults = {each.name: each.default for each in dataclasses.fields(kind)}
    changed = {name: value for name, value in settings.items() if value != defaults[name]}
    by = ", ".join(
        [f"style {kind.name}", f"seed {seed}", *(f"{k} {v}" for k, v in changed.items())]
    )
    return Plan(
        f"{kind.name}-{seed:04d}",
        (f"sonarbed worlds generate: {by}.",),
        {
            "title": f"{title}: {x_max - x_min:.1f} x {y_max - y_min:.1f} m",
            "source": f"generated by sonarbed worlds generate: {by}",
            "bounds_m": list(site.bounds_m),
            "route_m": [list(point) for point in route],
            "notes": {
                "bounds_m": "all numbers are drawn; materials and sizes by shares that are assumed",
                "route_m": f"at least {site.clear_m:g} m from everything, for a robot of "
                f"{site.radius_m:g} m radius",
            },
            "start": {"x_m": x_m, "y_m": y_m, "heading_deg": site.heading_deg},
            **{kind: tables for kind, tables in site.tables.items() if tables},
        },
    )
