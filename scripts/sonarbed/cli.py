"""The command line: which commands there are, and how errors end."""

from __future__ import annotations

import atexit
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress

import typer
from typer.exceptions import TyperException

from sonarbed.commands.acoustics import acoustics
from sonarbed.commands.arena import arena
from sonarbed.commands.dataset import dataset
from sonarbed.commands.demo import demo
from sonarbed.commands.exporting import export
from sonarbed.commands.filtering import filter_
from sonarbed.commands.hsr import hsr
from sonarbed.commands.importing import import_
from sonarbed.commands.map import map_
from sonarbed.commands.refine import refine
from sonarbed.commands.replay import replay
from sonarbed.commands.rings import rings
from sonarbed.commands.score import score
from sonarbed.commands.simulate import simulate
from sonarbed.commands.thesis import thesis
from sonarbed.commands.tune import tune
from sonarbed.commands.warmup import warmup
from sonarbed.commands.worlds import WorldsCommand, worlds
from sonarbed.compiling import told_of_compiling
from sonarbed.encoding import plain_where_needed
from sonarbed.interruption import INTERRUPTED, STOPPED, Interruption
from sonarbed.surroundings import open_streams, quiet_matplotlib
from sonarmap.errors import InputError

__all__ = ["app", "main"]

BAD_INPUT = 2

app = typer.Typer(
    name="sonarbed",
    help="Sonar mapping for small robots, judged by ground truth.",
    epilog="World -> drive -> log (-> filters) -> map -> score: each is a file to start from.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    # An error of ours ends in Python's own traceback, which can be copied into a report.
    pretty_exceptions_enable=False,
)
app.command()(demo)
app.command(cls=WorldsCommand)(worlds)
app.command()(rings)
app.command()(simulate)
app.command("import")(import_)
app.command()(export)
app.command("filter")(filter_)
app.command()(hsr)
app.command()(refine)
app.command("map")(map_)
app.command()(score)
app.command()(replay)
app.command()(dataset)
app.command()(arena)
app.command()(tune)
app.command()(thesis)
app.command()(acoustics)
app.command()(warmup)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code; errors are one line on standard error."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    open_streams()
    plain_where_needed(sys.stdout, sys.stderr)
    # A notebook that calls this lives on, whatever becomes of the command.
    interruption = Interruption(ends_process=argv is None)
    try:
        with (
            interruption.heard(),
            _modules_of_this_folder(),
            quiet_matplotlib(),
            told_of_compiling(),
        ):
            code = _run(arguments, interruption)
        if code == INTERRUPTED:  # Typer's way to tell of Ctrl-C
            raise KeyboardInterrupt
        # Now, not when Python ends: a full disk or a closed pipe is found out here.
        sys.stdout.flush()
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED if interruption.wait_told() else _fail(STOPPED, INTERRUPTED)
        if interruption.ends_process:
            # At once: to clear up after compilers and pools may take Python longer than a person
            # waits. It would also end by the signal, not with our code, if that met an `exec`.
            atexit._run_exitfuncs()  # semaphores and folders of the moment
            os._exit(code)
        return code
    except TyperException as error:
        message = error.format_message()
        # With no arguments the help was asked for, and has been printed.
        return _fail(f"{message.rstrip('.')}; {_where_help_is(error)}") if message else BAD_INPUT
    except (BrokenPipeError, SystemExit):
        # The reader of our output went away, as `head` does: not an error of ours. Typer has its
        # own exit for that.
        _drop_output()
        return 0
    except OSError as error:
        _drop_output()
        if _own_folder() is None:
            return _fail("the folder that this is run in does not exist any more")
        return _fail(f"{error.filename or 'output'}: {error.strerror or error}")
    except InputError as error:
        return _fail(str(error))
    return code if isinstance(code, int) else 0


def _run(arguments: Sequence[str], interruption: Interruption) -> object:
    try:
        return app(arguments, prog_name="sonarbed", standalone_mode=False)
    except Exception:
        # What is interrupted in C code, as a compiler, may end in any error.
        if interruption.is_heard:
            raise KeyboardInterrupt from None
        raise


@contextmanager
def _modules_of_this_folder() -> Iterator[None]:
    """Let ``package.module:Name`` find modules of the folder that the command is run in."""
    folder = _own_folder()
    if folder is None:
        yield
        return
    sys.path.append(folder)
    try:
        yield
    finally:
        sys.path.remove(folder)


def _own_folder() -> str | None:
    """Return the folder that the command is run in; None if somebody has removed it."""
    try:
        return os.getcwd()  # noqa: PTH109 - an entry of sys.path is a string
    except FileNotFoundError:
        return None


def _fail(message: str, code: int = BAD_INPUT) -> int:
    one_line = " ".join(message.split())
    with suppress(OSError):  # nobody hears, but the code tells
        sys.stderr.write(f"sonarbed: {one_line}\n")
        sys.stderr.flush()
    return code


def _where_help_is(error: TyperException) -> str:
    context = getattr(error, "ctx", None)
    return f"see '{context.command_path if context else 'sonarbed'} --help'"


def _drop_output() -> None:
    """Send what is still waiting to be printed nowhere, or Python complains when it ends."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
