"""The command line's frame: what all commands share, and what happens to mistakes."""

from __future__ import annotations

import errno
import math
import os
import signal
import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lostmotion.cli.spoken import Spoken
from lostmotion.cli.terminal import LOST, flush, give_up, is_of_output, open_up, say
from lostmotion.cli.typed import Typed
from lostmotion.errors import LostmotionError
from lostmotion.version import __version__

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
        say(f"lostmotion {__version__}")
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
    from lostmotion.analyses.quantities import amount as read
    from lostmotion.units import Quantity

    field = Quantity(si, example, above=above, high=high) if low is None else Quantity(si, example, low=low, high=high)
    return None if text is None else read(option, text, field)


def main() -> None:
    """Run the command line; whatever goes wrong is one message and an exit code, never a traceback.

    0 done; 1 done, and the answer is no: nothing fits, not reproduced, or the output could not be printed; 2 refused, nothing written; 130 stopped.
    """
    signal.signal(signal.SIGINT, _stop)
    there = open_up()
    code, message = _carried_out()
    lost = flush()
    if code == 0 and lost is not None:
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
    try:
        os.getcwd()  # noqa: PTH109 - the same, without a class around it
        app()
    except SystemExit as end:
        return (end.code, "") if isinstance(end.code, int) else (0 if end.code is None else 1, str(end.code or ""))
    except LostmotionError as error:
        return 2, str(error)
    except MemoryError:
        return 2, "not enough memory for that many poses, robots or visits; nothing was written"
    except OSError as error:
        return _of_system(error)
    return 0, ""


def _of_system(error: OSError) -> tuple[int, str]:
    """Return exit code and message for what the system refused."""
    if is_of_output(error):
        return 1, LOST if error.errno == errno.EPIPE else f"the output could not be printed: {error.strerror}; the results are written"
    if isinstance(error, FileNotFoundError) and error.filename is None:
        return 2, "the folder you stand in no longer exists\n  change to another one, for example: cd ~"
    return 2, f"{error.strerror or error}" + (f": {error.filename}" if error.filename else "")


def _stop(_signal: int, _frame: FrameType | None) -> None:
    """Remember that the user wants to stop: compiled code may swallow the exception and go on with half a result."""
    stopped.append(True)
    say("\nlostmotion: stopped", error=True)
    raise KeyboardInterrupt
