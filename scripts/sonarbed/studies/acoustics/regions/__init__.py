"""Regions of constant depth: what a sonar reads that turns on the spot, beside theory."""

from __future__ import annotations

from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.section import Section
from sonarbed.studies.acoustics.regions.room import room_of_glass
from sonarbed.studies.acoustics.regions.single import single_things

__all__ = ["run"]


def run(context: StudyContext) -> Section:
    """Turn a sonar before single things and in a room."""
    items = (single_things(context), room_of_glass(context))
    return Section("regions", "Regions of constant depth", items)
