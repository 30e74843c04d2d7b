"""`sonarbed filter`: what a reading filter makes of a log."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sonarbed.choices import listed
from sonarbed.options import Json, Param, check_log_out, make_part
from sonarmap.catalogue import FILTERS

if TYPE_CHECKING:
    from sonarmap import Filtered, ReadingScore, SonarLog

__all__ = ["check_output", "damage", "filter_", "judged_rows", "unused_rows"]


def filter_(
    log: Annotated[Path, typer.Argument(help="The log (Parquet).")],
    out: Annotated[Path, typer.Option(help="The filtered log to write (Parquet).")],
    method: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help=f"The reading filter: {listed(FILTERS)}, or package.module:Name.",
        ),
    ],
    param: Param = None,
    as_json: Json = False,
) -> None:
    """Let a filter change, reject or doubt the readings of a log, which stays as it is.

    Rejected and stale readings stay in the file, marked; nothing maps or judges them.

    Example, after `sonarbed simulate thesis-exp1 --out drive.parquet`:

      sonarbed filter drive.parquet --method hsr \
        --param threshold_m=0.8 --out filtered.parquet
    """
    import sonarmap as sm
    from sonarbed.console import print_json, print_table, say, working
    from sonarmap.account import account_of
    from sonarmap.pipeline import apply_all

    check_output(log, out)
    before = sm.read_log(log)
    chosen = make_part("filter", method, param)
    with working("filtering"):
        made = apply_all([chosen], before)
        score = None if before.truth is None else sm.score_readings(before, made)
        made.log.write(out)
    facts, account = _facts(before, made), account_of(before).to_dict()
    if as_json:
        about = {"file": str(out), "filter": repr(chosen), "account": account, **facts}
        print_json({**about, "score": None if score is None else score.to_dict()})
        return
    rows = [[name.replace("_", " "), str(count)] for name, count in facts.items()]
    print_table(f"{chosen.name}: {log}", ["readings", "number"], [*unused_rows(account), *rows])
    if score is not None:
        print_table("Readings by truth", ["readings", "wrong", "right"], judged_rows(score))
        say(damage(score))
    say(f"Written: {out}")


def check_output(log: Path, out: Path) -> None:
    """Raise `InputError` if the output is the log itself or could not be written."""
    from sonarmap.errors import InputError

    if log.resolve() == out.resolve():
        raise InputError(f"--out must be another file than the log, got {str(out)!r}")
    check_log_out(out)


def _facts(before: SonarLog, made: Filtered) -> dict[str, int]:
    import numpy as np

    used = before.usable
    return {
        "readings": int(used.sum()),
        "changed": int((made.changed & used).sum()),
        "rejected": int((made.rejected & used).sum()),
        "doubted": int((~np.isnan(made.doubt) & used).sum()),
        "marked_stale": int((made.log.stale & used).sum()),
    }


def unused_rows(account: dict[str, Any]) -> list[list[str]]:
    """Return table rows of the readings that came in and of those that were not used."""
    if account["used"] == account["in_log"]:
        return []
    return [
        ["readings of the log", str(account["in_log"])],
        *([f"  not used: {n.replace('_', ' ')}", str(c)] for n, c in account["unused"].items()),
    ]


def damage(score: ReadingScore) -> str:
    """Return in a sentence what was mended and what was spoiled."""
    told = score.to_dict()

    def share(name: str) -> str:
        return "-" if told[name] is None else f"{told[name]:.1%}"

    return (
        f"Of the wrong readings {share('mended_share')} were mended; "
        f"of the right ones {share('spoiled_share')} were spoiled."
    )


def judged_rows(score: ReadingScore) -> list[list[str]]:
    """Return table rows of what became of wrong and of right readings."""
    told = score.to_dict()
    counts = told["counts"]

    def of(part: str, whole: str) -> str:
        share = counts[part] / counts[whole] if counts[whole] else None
        return str(counts[part]) if share is None else f"{counts[part]} ({share:.1%})"

    def error(group: str, key: str) -> str:
        before, after = (told["errors"][group][when]["cone"] for when in ("before", "after"))
        if key == "median_m":
            return " to ".join("-" if e[key] is None else f"{e[key]:.3f}" for e in (before, after))
        return " to ".join(
            "-" if e["beyond"][1][key] is None else f"{e['beyond'][1][key]:.1%}"
            for e in (before, after)
        )

    def share(name: str) -> str:
        return "-" if told[name] is None else f"{told[name]:.1%}"

    rejections = [
        ["rejected (wrong: caught, right: lost)", of("caught", "wrong"), of("lost", "right")]
    ]
    doubts = [
        ["area under the ROC curve of the doubt", share("roc_auc"), ""],
        ["caught while 1 % of the right are lost", share("caught_at_lost_1_percent"), ""],
    ]
    return [
        ["number", str(counts["wrong"]), str(counts["right"])],
        *(rejections if counts["caught"] + counts["lost"] else []),
        *(doubts if told["roc_auc"] is not None else []),
        ["updated", of("wrong_updated", "wrong"), of("right_updated", "right")],
        ["mended (wrong, now within 0.1 m)", of("mended", "wrong"), ""],
        ["spoiled (right, now beyond 0.1 m)", "", of("spoiled", "right")],
        ["precision of the updates", share("precision"), ""],
        ["recall of the updates", share("recall"), ""],
        [
            "median error, before to after, m",
            *(error(group, "median_m") for group in ("wrong", "right")),
        ],
        *(
            [
                f"{name} by more than 0.3 m",
                *(error(group, key) for group in ("wrong", "right")),
            ]
            for name, key in (("too long", "share_too_long"), ("too short", "share_too_short"))
        ),
    ]
