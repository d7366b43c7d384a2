"""The command line's frame: what all commands share, and what happens to mistakes."""

from __future__ import annotations

import math
import os
import signal
import sys
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lostmotion import __version__
from lostmotion.cli.spoken import Spoken
from lostmotion.cli.typed import Typed
from lostmotion.errors import LostmotionError

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType

stopped: list[bool] = []
STOPPED = 130  # the shell's own code for it


class _App(typer.Typer):
    """Commands that say what is wrong with what was typed."""

    def command(self, name: str | None = None, **options: Any) -> Callable[[Any], Any]:  # noqa: ANN401 - typer's own options
        return super().command(name, cls=Typed, **options)


app = _App(
    cls=Spoken,
    help="How accurate will this robot arm be before it is built, where in its workspace, and which part is to blame?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _print_version(wanted: bool) -> None:  # noqa: FBT001 - typer hands the switch over
    if wanted:
        typer.echo(f"lostmotion {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[bool, typer.Option("--version", help="Print the version and stop.", is_eager=True, callback=_print_version)] = False,  # noqa: FBT002
) -> None:
    """Take the options that go before a command."""


def amount(
    option: str,
    text: str | None,
    si: str,
    example: str,
    above: float = 0.0,
    *,
    low: float | None = None,
    high: float = math.inf,
) -> float | None:
    """Read what an option asks for, in SI, above `above`, or where `low` is given at least that; errors as `ask.amounts.amount`."""
    from lostmotion.ask.amounts import amount as read
    from lostmotion.units import Quantity

    field = Quantity(si, example, above=above, high=high) if low is None else Quantity(si, example, low=low, high=high)
    return None if text is None else read(option, text, field)


def main() -> None:
    """Run the command line; a mistake in the input is one message and exit code 2, never a traceback."""
    signal.signal(signal.SIGINT, _stop)
    try:
        app()
    except LostmotionError as error:
        code, message = 2, str(error)
    except MemoryError:
        code, message = 2, "not enough memory for that many poses, robots or visits; nothing was written"
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or Python complains once more when it closes the pipe
        code, message = 1, "the output was closed before all was printed; the results are written"
    typer.echo(f"lostmotion: {message}", err=True)
    sys.exit(code)


def _stop(_signal: int, _frame: FrameType | None) -> None:
    """Remember that the user wants to stop: compiled code may swallow the exception and go on with half a result."""
    stopped.append(True)
    typer.echo("\nlostmotion: stopped", err=True)
    raise KeyboardInterrupt
