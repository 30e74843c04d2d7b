"""`sonarbed thesis`: every table and figure of the thesis that data can make."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

__all__ = ["thesis"]


def thesis(
    out: Annotated[Path, typer.Option(help="The folder of the report.")] = Path("thesis"),
    study: Annotated[
        list[str] | None,
        typer.Option(help="Run only this study, such as wall_sizes; repeatable."),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Fewer seeds, shorter drives: under 3 minutes.")
    ] = False,
    again: Annotated[
        bool, typer.Option("--again", help="Run studies again that are done already.")
    ] = False,
    sonar: Annotated[str, typer.Option(help="Preset of the simulated sonar.")] = "thesis",
    jobs: Annotated[int, typer.Option(help="Processes that work at once.")] = 2,
) -> None:
    """Make the thesis again from simulated drives, each claim tested against the truth.

    Studies that are done are kept: after an interruption the same command goes on.

    Example: sonarbed thesis --quick --out report
    """
    from sim.runs.parallel import checked_jobs
    from sim.sonar.presets import preset
    from sonarbed.console import progress, say
    from sonarbed.reporting.context import StudyContext
    from sonarbed.studies.thesis import STUDIES, load
    from sonarbed.studies.thesis.questions import ThesisSection
    from sonarbed.studies.thesis.report import write_thesis_report

    checked_jobs(jobs, "--jobs")
    preset(sonar)  # an unknown one ends here, before it has claimed the folder
    wanted = list(study or STUDIES)
    runs = {name: load(name) for name in wanted}
    with progress() as bars:
        overall = bars.add_task("studies", total=len(runs))
        current = bars.add_task("", total=1)
        context = StudyContext(
            out,
            quick=quick,
            sonar=sonar,
            report="thesis",
            jobs=jobs,
            on_progress=lambda label, done, total: bars.update(
                current, description=label, completed=done, total=total
            ),
        )
        context.claim()
        for name, run in runs.items():
            at_work = context.on_study(name)
            if again or ThesisSection.load(at_work.study_folder) is None:
                run(at_work).save(at_work.study_folder)
            bars.advance(overall)
        done = [ThesisSection.load(context.on_study(name).study_folder) for name in STUDIES]
        html, markdown = write_thesis_report(context, [section for section in done if section])
    say(f"Report: {html}, {markdown}")
