"""`sonarbed arena`: every method and filter on the same logs, judged by truth."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sonarbed.options import Json

if TYPE_CHECKING:
    from sim.runs.jobs import JobProgress
    from sonarbed.studies.arena.running import ArenaResult
    from sonarbed.studies.arena.table import Table

__all__ = ["arena"]

# So many failures are printed; the others are in the file.
_SHOWN = 5


def arena(
    out: Annotated[Path, typer.Option(help="The folder of the table and the report.")] = Path(
        "arena"
    ),
    method: Annotated[
        list[str] | None,
        typer.Option(help="Only this method, a name or package.module:Name; repeatable."),
    ] = None,
    filter_: Annotated[
        list[str] | None,
        typer.Option("--filter", help="With --method: this filter before it; repeatable."),
    ] = None,
    against: Annotated[
        str | None,
        typer.Option(metavar="NAMES", help="Rows to set it against, with commas between them."),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Few rooms and short drives: under 3 minutes.")
    ] = False,
    jobs: Annotated[int, typer.Option(help="Processes of this machine.")] = 1,
    dask: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Scheduler of a Dask cluster in place of --jobs."),
    ] = None,
    tune: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json",
            help="Tune every method and filter on generated rooms into this file, and end.",
        ),
    ] = None,
    budget: Annotated[int, typer.Option(help="With --tune: evaluations of each.")] = 40,
    seed: Annotated[int, typer.Option(help="With --tune: seed of the search.")] = 0,
    timeout: Annotated[float, typer.Option(help="Seconds that a run may take.")] = 120.0,
    as_json: Json = False,
) -> None:
    r"""Run mapping methods and filters on the same logs and print who knows most of the rooms.

    Stopped or killed at any moment, the same command goes on. In the same folder more methods may
    be entered later; what has run is not run again.

    Examples, all of them, and your own:

      sonarbed arena --quick --jobs 2 --out arena

      sonarbed arena --quick --out arena \
        --method my_module:MyMapper --against sheet
    """
    if tune is not None:
        _tune(tune, budget=budget, seed=seed, jobs=jobs)
        return
    from sim.runs.jobs import DaskCluster, Processes, ThisProcess, Workers
    from sonarbed.console import print_json, progress
    from sonarbed.studies.arena import entries as entering
    from sonarbed.studies.arena import plan as planning
    from sonarbed.studies.arena.report import write_arena_report
    from sonarbed.studies.arena.running import run_arena
    from sonarbed.studies.arena.table import Table
    from sonarmap.errors import InputError, positive

    if filter_ and not method:
        raise InputError("--filter is for --method: without one all filters run")
    if dask is not None and jobs != 1:
        raise InputError("give --jobs or --dask, not both: the cluster has its own processes")
    workers: Workers = (
        DaskCluster(dask) if dask is not None else ThisProcess() if jobs == 1 else Processes(jobs)
    )
    positive("--timeout", timeout)
    rivals = [name.strip() for name in against.split(",")] if against else []
    chosen = entering.entries_of(method, filter_ or ()) if method else entering.all_entries()
    mine = [entry.label for entry in chosen] if method else []
    chosen += [entry for entry in entering.entries_of(rivals, ()) if rivals and entry not in chosen]
    plan = planning.quick() if quick else planning.full()
    with progress() as bars:
        tasks: dict[str, Any] = {}

        def show(phase: str, told: JobProgress) -> None:
            if phase not in tasks:
                tasks[phase] = bars.add_task(phase, total=told.total)
            label = phase + (f", {told.failed} failed" if told.failed else "")
            bars.update(tasks[phase], completed=told.done + told.failed, description=label)

        result = run_arena(plan, chosen, out, workers=workers, timeout_s=timeout, on_progress=show)
    table = Table(result.rows)
    pages = write_arena_report(plan, result, out / "report")
    told = _told(table, result, mine, rivals)
    if as_json:
        print_json(told)
        return
    _print(table, result, told, pages)


def _tune(out: Path, *, budget: int, seed: int, jobs: int) -> None:
    from sonarbed.console import print_table, progress, say
    from sonarbed.options import check_writable
    from sonarbed.studies.arena.tuning import tune_all

    check_writable(out, ".json")
    with progress() as bars:
        task = bars.add_task("tuning", total=None)
        found = tune_all(
            out,
            budget=budget,
            seed=seed,
            jobs=jobs,
            on_progress=lambda label, done, total: bars.update(task, completed=done, total=total),
        )
    for kind in ("methods", "filters"):
        print_table(
            f"Skill on the training rooms, {kind}",
            ["name", "published", "tuned"],
            [
                [name, f"{told['published_skill']:.3f}", f"{told['skill']:.3f}"]
                for name, told in found[kind].items()
            ],
        )
    say(f"Written: {out}")


def _told(table: Table, result: ArenaResult, mine: list[str], rivals: list[str]) -> dict[str, Any]:
    standings = table.standings()
    return {
        "leaderboard": [
            {
                "entry": each.entry,
                "skill": _plain(each.skill.value),
                "low": _plain(each.skill.low),
                "high": _plain(each.skill.high),
                "pooled": _plain(each.pooled),
                "worst": _plain(each.worst),
                "rank": _plain(each.rank),
                "runs": each.runs,
            }
            for each in standings
        ],
        "paired": [
            {"entry": entry, "against": rival, **_difference(table, entry, rival)}
            for entry in mine
            for rival in rivals
            if entry in table.entries and rival in table.entries and entry != rival
        ],
        "runs": len(table.rows),
        "failed": result.runs.failed,
        "failures": [failure.to_dict() for failure in result.runs.failures[:_SHOWN]],
    }


def _difference(table: Table, entry: str, rival: str) -> dict[str, Any]:
    gained = table.paired(entry, rival)
    return {
        "skill_gained": _plain(gained.value),
        "low": _plain(gained.low),
        "high": _plain(gained.high),
    }


def _plain(value: float) -> float | None:
    return None if value != value else value


def _print(
    table: Table, result: ArenaResult, told: dict[str, Any], pages: tuple[Path, Path]
) -> None:
    from sonarbed.console import print_table, say
    from sonarbed.studies.arena.running import FAILURES

    print_table(
        f"{len(table.rows)} runs in {len(table.rooms)} rooms",
        ["entry", "skill (95 %)", "pooled", "worst", "rank", "seconds"],
        [
            [
                each.entry,
                each.skill.text(),
                f"{each.pooled:.2f}",
                f"{each.worst:.2f}",
                f"{each.rank:.1f}",
                f"{each.means['seconds']:.3f}",
            ]
            for each in table.standings()
        ],
    )
    for pair in told["paired"]:
        gained = table.paired(pair["entry"], pair["against"])
        decided = "" if gained.sign else ", not decided"
        say(f"{pair['entry']} against {pair['against']}: skill {gained.text()}{decided}")
    for failure in result.runs.failures[:_SHOWN]:
        say(f"Failed: {failure.label}: {failure.error}")
    if result.runs.failed:
        say(f"{result.runs.failed} runs failed: see {FAILURES}.")
    say(f"Report: {pages[0]}, {pages[1]}")
