"""`sonarbed acoustics`: what the simulated sonars do, beside theory."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

__all__ = ["acoustics"]


def acoustics(
    out: Annotated[Path, typer.Option(help="The folder of the page.")] = Path("acoustics"),
    quick: Annotated[
        bool, typer.Option("--quick", help="Coarser sweeps, shorter drives: under 40 seconds.")
    ] = False,
    jobs: Annotated[int, typer.Option(help="Processes that work at once.")] = 2,
) -> None:
    """Draw what the sonars return, from where and why, beside theory.

    A page with its figures and numbers, from the beam to a hallway beside a real log.

    Example: sonarbed acoustics --quick --out acoustics
    """
    from sim.runs.parallel import checked_jobs
    from sonarbed.console import progress, say
    from sonarbed.reporting.context import StudyContext
    from sonarbed.reporting.report import write_report
    from sonarbed.studies.acoustics import PARTS, load

    checked_jobs(jobs, "--jobs")
    with progress() as bars:
        overall = bars.add_task("parts", total=len(PARTS))
        current = bars.add_task("", total=1)
        context = StudyContext(
            out,
            quick=quick,
            sonar="physical",
            report="acoustics",
            jobs=jobs,
            on_progress=lambda label, done, total: bars.update(
                current, description=label, completed=done, total=total
            ),
        )
        context.claim()
        sections = []
        for name in PARTS:
            at_work = context.on_study(name)
            section = load(name)(at_work)
            section.save(at_work.study_folder)
            sections.append(section)
            bars.advance(overall)
        html, markdown = write_report(context, sections, package="sonarbed.studies.acoustics")
    say(f"Page: {html}, {markdown}")
