"""The command line: which commands there are, and how errors end."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import typer
from typer.exceptions import TyperException

from sonarbed.commands.demo import demo
from sonarbed.commands.importing import import_
from sonarbed.commands.map import map_
from sonarbed.commands.score import score
from sonarbed.commands.simulate import simulate
from sonarbed.commands.thesis import thesis
from sonarbed.commands.worlds import worlds
from sonarmap.errors import InputError

__all__ = ["app", "main"]

# Exit codes as shells know them: 2 for bad input, 128 + 2 for an interrupt.
BAD_INPUT, INTERRUPTED = 2, 130

app = typer.Typer(
    name="sonarbed",
    help="Sonar mapping for small robots, judged by ground truth.",
    epilog="World -> drive -> log -> map -> score: each is a file to stop at and start from.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
)
app.command()(demo)
app.command()(worlds)
app.command()(simulate)
app.command("import")(import_)
app.command("map")(map_)
app.command()(score)
app.command()(thesis)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code; errors are one line on standard error."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        code = app(arguments, prog_name="sonarbed", standalone_mode=False)
    except (KeyboardInterrupt, typer.Abort):
        return _fail("interrupted; what was finished is kept", INTERRUPTED)
    except TyperException as error:
        # With no arguments the help was asked for, and has been printed.
        message = error.format_message()
        return _fail(f"{message} See 'sonarbed --help'.", BAD_INPUT) if message else BAD_INPUT
    except InputError as error:
        return _fail(str(error), BAD_INPUT)
    except BrokenPipeError:
        # The reader of our output went away, as `head` does: not an error of ours.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    return code if isinstance(code, int) else 0


def _fail(message: str, code: int) -> int:
    one_line = " ".join(message.split())
    sys.stderr.write(f"sonarbed: {one_line}\n")
    return code
