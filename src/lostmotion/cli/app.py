"""The command line: one command per question, and what happens to mistakes."""

from __future__ import annotations

import atexit
import errno
import gc
import importlib
import logging
import os
import signal
import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer
from typer.core import TyperCommand, TyperGroup

from lostmotion import QUESTIONS
from lostmotion.cli.answering import stopped, swallowed
from lostmotion.cli.generator import command_name, command_of
from lostmotion.cli.loading import is_of_loading, is_of_memory, not_loaded, too_little_space
from lostmotion.cli.terminal import (
    LOST,
    begin_printing,
    flush,
    give_up,
    is_of_output,
    is_printing,
    open_up,
    say,
)
from lostmotion.errors import InputError, LostmotionError, Problem, nearest, shown
from lostmotion.extensions import extensions, question_named
from lostmotion.version import __version__

if TYPE_CHECKING:
    from types import FrameType

# Other names of commands.
_ALIASES: Final = {"run": "study"}
# New objects between two garbage collections. Libraries make a million objects that stay; Python's
# own 700 would search them again and again.
_COLLECTED_EVERY: Final = 100_000


def _completes(ctx: typer.Context | None) -> bool:
    """Return whether a shell asks for words that complete what is typed."""
    return ctx is not None and ctx.resilient_parsing


class _Questions(TyperGroup):
    """The commands, each made when it is asked for. A shell that completes what is typed gets their
    names one word at a time.
    """

    def list_commands(self, ctx: typer.Context) -> list[str]:  # type: ignore[override] # Click's own signature
        """Return the names of the questions, in the order of the help."""
        names = [command_name(name) for name in (*QUESTIONS, *extensions("questions"))]
        return (
            [*dict.fromkeys(name.partition(" ")[0] for name in names)] if _completes(ctx) else names
        )

    def get_command(self, ctx: typer.Context, cmd_name: str) -> Any:  # type: ignore[override]  # noqa: ANN401 - Click's own class
        """Return the command of this name, None where there is none."""
        name = _ALIASES.get(cmd_name, cmd_name).replace(" ", "_")
        if name not in QUESTIONS and name in extensions("questions"):
            return _command_of_extension(name)
        if name not in QUESTIONS:
            behind = {
                each.removeprefix(f"{name}_"): self.get_command(ctx, each)
                for each in QUESTIONS
                if each.startswith(f"{name}_")
            }
            return (
                TyperGroup(
                    name=cmd_name,
                    commands=behind,
                    help=f"What `lostmotion {cmd_name}` writes; each has its own --help.",
                    rich_markup_mode=None,
                )
                if behind
                else None
            )
        return command_of(getattr(importlib.import_module(QUESTIONS[name]), name))

    def resolve_command(self, ctx: typer.Context, args: list[str]) -> Any:  # type: ignore[override]  # noqa: ANN401 - Click's own class
        """Return the command that was typed. Raises InputError where there is none of this name."""
        if _completes(ctx):
            return super().resolve_command(ctx, args)  # type: ignore[arg-type, unused-ignore]
        if refused := too_little_space():  # before the libraries of any command are loaded
            raise LostmotionError(refused)
        if " ".join(args[:2]) in map(command_name, QUESTIONS):  # `export c`
            args = [" ".join(args[:2]), *args[2:]]
        word = args[0]
        if word in QUESTIONS:
            return super().resolve_command(ctx, args)  # type: ignore[arg-type, unused-ignore]
        # `export --help`
        if args[1:] == ["--help"] and any(
            command_name(name).startswith(f"{word} ") for name in QUESTIONS
        ):
            return super().resolve_command(ctx, args)  # type: ignore[arg-type, unused-ignore]
        names = [command_name(name) for name in (*QUESTIONS, *extensions("questions"))]
        if word not in {*names, *_ALIASES}:
            raise InputError(
                [
                    Problem(
                        "",
                        "command",
                        shown(word),
                        "one of " + ", ".join(names),
                        "lostmotion study arm.toml",
                        nearest(word, names),
                    )
                ]
            )
        return super().resolve_command(ctx, args)  # type: ignore[arg-type, unused-ignore]


class _Broken(TyperCommand):
    """The command of a question that cannot be loaded: the help of all commands states why."""

    reason: InputError

    def parse_args(self, ctx: typer.Context, args: list[str]) -> list[str]:  # type: ignore[override]  # noqa: ARG002 - as declared
        """Raise the reason."""
        raise self.reason


def _command_of_extension(name: str) -> Any:  # noqa: ANN401 - Click's own class
    try:
        return command_of(question_named(name))  # type: ignore[arg-type] # there is one
    except InputError as error:
        (problem,) = error.problems
        broken = _Broken(name, help=f"Cannot be loaded: {problem.file}: {problem.found}")
        broken.reason = error
        return broken


app = typer.Typer(
    cls=_Questions,
    help=(
        "How accurate will this robot arm be before it is built, where in its workspace, and "
        "which part is to blame?"
    ),
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _print_version(wanted: bool) -> None:  # noqa: FBT001 - typer hands the switch over
    if wanted:
        say(f"lostmotion {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[  # noqa: FBT002
        bool,
        typer.Option(
            "--version", help="Print the version and stop.", is_eager=True, callback=_print_version
        ),
    ] = False,
) -> None:
    """Take the options that go before a command."""


def main() -> None:
    """Run the command line; whatever goes wrong is one message and an exit code, never a traceback.

    0 done; 1 done, and the answer is no: nothing fits, not reproduced, or the output could not be
    printed; 2 refused, nothing written; 130 stopped.
    """
    signal.signal(signal.SIGINT, _stop)
    sys.unraisablehook = _note_memory
    gc.set_threshold(_COLLECTED_EVERY)
    # or Python searches all of them again at its end, for a tenth of a short command's time
    atexit.register(gc.freeze)
    # JAX logs a driver that does not load over a dozen lines; the message of a missing GPU says how
    # to see them.
    logging.getLogger("jax").setLevel(logging.CRITICAL)
    there = open_up()
    code, message = _carried_out()
    lost = flush()
    if code == 0 and lost is not None:
        begin_printing()
        code, message = _of_system(lost)
    if code == 0 and not there:
        code, message = 1, LOST
    with suppress(OSError):
        if message:
            say(f"lostmotion: {message}", error=True)
    give_up()
    sys.exit(code)


def _carried_out() -> tuple[int, str]:
    """Run the command and return its exit code and message."""
    begin_printing(begun=False)
    try:
        os.getcwd()  # noqa: PTH109 - the same, without a class around it
        app()
    except SystemExit as end:
        return (
            (end.code, "")
            if isinstance(end.code, int)
            else (0 if end.code is None else 1, str(end.code or ""))
        )
    except LostmotionError as error:
        return 2, str(error)
    except (MemoryError, ImportError, OSError, RuntimeError) as error:
        if is_of_loading(error) or (is_of_memory(error) and not isinstance(error, OSError)):
            return _of_memory(error)
        if isinstance(error, OSError):
            return _of_system(error)
        raise
    return 0, ""


def _of_memory(error: BaseException) -> tuple[int, str]:
    """Return exit code and message for memory that ran out, or a package that is not loaded."""
    if is_of_memory(error) and is_printing():
        return 1, "not enough memory to print all of it; the results are written"
    if isinstance(error, MemoryError):
        return 2, "not enough memory for that many poses, robots or visits; nothing was written"
    return 2, not_loaded(error)


def _of_system(error: OSError) -> tuple[int, str]:
    """Return exit code and message for what the system refused."""
    if is_of_output(error):
        return (
            1,
            LOST
            if error.errno == errno.EPIPE
            else f"the output could not be printed: {error.strerror}; the results are written",
        )
    if isinstance(error, FileNotFoundError) and error.filename is None:
        return (
            2,
            "the folder you stand in no longer exists\n  change to another one, for example: cd ~",
        )
    return 2, f"{error.strerror or error}" + (f": {error.filename}" if error.filename else "")


def _note_memory(ignored: sys.UnraisableHookArgs) -> None:
    """Remember that memory ran out where the error could not be raised: SciPy for one then
    continues with tables that are not filled.
    """
    if isinstance(ignored.exc_value, MemoryError):
        swallowed.append(ignored.exc_value)
    else:
        sys.__unraisablehook__(ignored)


def _stop(_signal: int, _frame: FrameType | None) -> None:
    """Remember that the user wants to stop: compiled code may swallow the exception and continue
    with half a result.
    """
    stopped.append(True)
    say("\nlostmotion: stopped", error=True)
    raise KeyboardInterrupt
