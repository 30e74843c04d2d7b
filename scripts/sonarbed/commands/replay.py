"""`sonarbed replay`: a log beside its simulation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sonarbed.choices import listed, simulator
from sonarbed.options import Json, Png, Setting, check_log_out, check_writable

if TYPE_CHECKING:
    from sim.runs.replay import Replay

__all__ = ["replay"]


def replay(
    log: Annotated[Path, typer.Argument(help="The log (Parquet), of a real robot or simulated.")],
    world: Annotated[str, typer.Option(help="The room that it was taken in, or its file.")],
    sonar: Annotated[
        str,
        typer.Option(
            help=f"The acoustics: {listed(simulator('sonar_presets'))}; the ring is the log's."
        ),
    ] = "physical",
    poses: Annotated[
        str,
        typer.Option(
            metavar="auto|true|odometry",
            help="Where the robot was. Auto is the truth of a simulated log, else odometry.",
        ),
    ] = "auto",
    align: Annotated[
        bool,
        typer.Option("--align", help="Find where the log's frame lies in the room; by odometry."),
    ] = False,
    seed: Annotated[int, typer.Option(help="Seed of the noise, and of the alignment.")] = 0,
    setting: Setting = None,
    out: Annotated[
        Path | None, typer.Option(help="Write the simulated readings as a log (Parquet).")
    ] = None,
    png: Png = None,
    as_json: Json = False,
) -> None:
    r"""Fire simulated sonars where a log's sonars fired, and compare reading by reading.

    How often both are silent, how near the ranges are, and what the likely causes of the rest
    are, by the sonars of a room that was measured.

    Example, after `sonarbed simulate office --engine segments --out drive.parquet`:

      sonarbed replay drive.parquet --world office \
        --png replay.png
    """
    import sim
    import sonarmap as sm
    import worlds
    from sonarbed.console import print_json, say, working
    from sonarbed.options import load_world
    from sonarmap.errors import InputError

    if out is not None:
        check_log_out(out)
    check_writable(png, ".png")
    room, readings = load_world(world, setting), sm.read_log(log)
    motion = None
    if align:
        if poses == "true":
            raise InputError("--align finds where odometry lies: --poses must not be true")
        poses = "odometry"
        with working("aligning"):
            motion = worlds.align(readings, room, seed=seed)
            readings = motion.moved(readings)
    with working("replaying"):
        told = sim.replay(readings, room, sonar=sonar, seed=seed, poses=poses)  # type: ignore[arg-type]  # it checks
    if out is not None:
        told.simulated.write(out)
    if png is not None:
        from sonarbed.reporting.replay_picture import draw_replay

        with working("drawing"):
            draw_replay(room, told, png)
    if as_json:
        aligned = {} if motion is None else {"alignment": motion.to_dict()}
        print_json({**told.to_dict(), **aligned})
        return
    _print(told, f"{log} in {room.name}, simulated by the sonar {sonar}")
    if motion is not None:
        say(f"Aligned: {motion}.")
    for written in (out, png):
        if written is not None:
            say(f"Written: {written}")


def _print(told: Replay, title: str) -> None:
    from sim.runs.replay import CLOSE_M
    from sonarbed.console import print_table, say

    real, simulated = told.silence_by_sonar()
    print_table(
        title,
        ["sonar", "no echo, log", "no echo, simulated"],
        [
            *(
                [str(k), *("" if share != share else f"{share:.0%}" for share in pair)]
                for k, pair in enumerate(zip(real, simulated, strict=True))
            ),
            ["all", *(f"{silent.mean():.0%}" for silent in told.silent)],
        ],
    )
    near = ", ".join(f"{told.within(m):.0%} within {100 * m:.0f} cm" for m in CLOSE_M)
    by = "odometry: its errors count as well" if told.poses == "odometry" else "the truth"
    say(f"Poses by {by}.")
    say(f"Echo or silence agrees in {told.agreement:.1%}.")
    say(f"Of {int(told.both_measured.sum())} with a range in both: {near}.")
    for way, causes in told.disagreements().items():
        if causes:
            parts = ", ".join(
                f"{count} {name.lower().replace('_', ' ')}" for name, count in causes.items()
            )
            say(f"{sum(causes.values())} {way.replace('_', ' ')}, likely causes: {parts}.")
    say(f"{told.account}.")
