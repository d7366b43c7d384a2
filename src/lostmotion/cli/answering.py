"""Asks a question with what was typed, writes its report, and prints what was found."""

from __future__ import annotations

import inspect
import sys
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import typer

from lostmotion.analyses.signature import results_folder
from lostmotion.cli.shared_options import COPIES, shared_options
from lostmotion.cli.terminal import begin_printing, say, say_json
from lostmotion.errors import refuse_argument

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from lostmotion.analyses.result import Result
    from lostmotion.analyses.signature import Question

# Columns of a line that every terminal shows whole, and the gap between two statements on it.
_LINE: Final = 80
_GAP: Final = "   "
# The options that replace the one screen that is printed.
_PRINTED: Final = ("json", "full", "quiet")
# Beginnings of lines that are copied whole.
_COPIED: Final = (" ", "File:", "Folder:")
STOPPED: Final = 130  # the shell's own code for it
stopped: list[bool] = []
# where they could not be raised: what was computed since is not to be trusted
swallowed: list[MemoryError] = []


def answer(function: Callable[..., Any], question: Question, typed: Mapping[str, Any]) -> None:
    """Ask the question, write its report, and print what was found."""
    given = {
        each.name: typed[each.name]
        for each in question.options
        if typed[each.name] or typed[each.name] == "" or each.required
    }
    if question.folder is None:
        data = function(**given)
        if question.in_words is None or typed["json"]:
            say_json(data)
        else:
            say(_folded(question.in_words(data)))
        return
    from lostmotion.analyses.result import PartialResultError
    from lostmotion.io.flexibility_files import keep_flexibilities
    from lostmotion.reporting.folder import refuse_existing
    from lostmotion.reporting.progress import ProgressBar

    common = {
        each.name: each.read(typed[each.name], {}) if each.words else typed[each.name]
        for each in shared_options(question)
    }
    _refuse_conflicts(common)
    own = "out" not in common  # a folder that is one of the question's arguments
    force = common.get("force", False)
    out = common.get("out") or (None if common["json"] else _folder(question, given))
    if out is not None and force:
        _refuse_to_replace(given, out)
    callbacks = {each.name for each in question.parameters if each.argument.python_only}
    if "ready" in callbacks and out is not None:
        given["ready"] = partial(refuse_existing, out, force=force)
    keep_flexibilities()
    try:
        with ProgressBar() as bar:
            found = _asked(
                function, {**given, **({"progress": bar} if "progress" in callbacks else {})}
            )
    except PartialResultError as error:
        found = error.partial()
    except KeyboardInterrupt as stop:
        notes = getattr(stop, "__notes__", ())
        for note in notes or (
            () if own else ("nothing was written: a result is written only once it is complete",)
        ):
            say(f"lostmotion: {note}", error=True)
        raise typer.Exit(STOPPED) from None
    if stopped:
        raise typer.Exit(STOPPED)
    if swallowed:
        raise swallowed[0]
    _deliver(found if isinstance(found, list) else [found], None if own else out, common, own=own)


def _deliver(
    results: list[Result], out: str | None, common: Mapping[str, Any], *, own: bool
) -> None:
    """Write the report of each result, and print what was found: one screen of it before the
    report, which takes a second to draw.
    """
    copies = {name: common[name] for name in COPIES if name in common}
    first = out is not None and not any(common.get(name) for name in _PRINTED)
    lost = _show_first_screens(results) if first else None
    written = [
        each.report(out, force=common.get("force", False), **copies)  # type: ignore[arg-type] # None: its own folder
        for each in results
        if own or out is not None
    ]
    if lost is not None:
        begin_printing()
        raise lost
    _show(results, written, common, first_screens=not first)


def _show_first_screens(results: list[Result]) -> Exception | None:
    """Print one screen of each result before its report is written, and return what went wrong: a
    closed pipe must not cost the results.
    """
    begin_printing()
    try:
        for each in results:
            each.summary()
        sys.stdout.flush()
    except (OSError, MemoryError, ImportError) as error:
        return error
    finally:
        begin_printing(begun=False)
    return None


def _folded(text: str) -> str:
    """Return a text with its lines folded, but for what is copied whole: commands, which are
    indented, and the name of what was written.
    """
    from lostmotion.reporting.bars_on_screen import wrapped

    lines = text.splitlines()
    return "\n".join(
        part
        for line in lines
        for part in ([line] if line.startswith(_COPIED) else wrapped(line, _LINE))
    )


def _refuse_conflicts(common: Mapping[str, Any]) -> None:
    """Raise InputError for an output folder without a name, and for several options of what to
    print.
    """
    if common.get("out") == "":
        raise refuse_argument("out", "", "a folder", out="results")
    chosen = [name for name in _PRINTED if common.get(name)]
    if len(chosen) > 1:
        raise refuse_argument(
            ", ".join(chosen), f"{len(chosen)} of them", "one of them, or none", **{chosen[0]: True}
        )


def _refuse_to_replace(given: Mapping[str, Any], out: str) -> None:
    """Raise InputError for a folder of results that holds a file which the command reads, whatever
    the option: it would be replaced.
    """
    folder = Path(out).resolve()
    for file in filter(_is_file, _texts(given.values())):
        if Path(file).resolve().is_relative_to(folder):
            raise refuse_argument(
                "out", out, f"another folder than that of '{file}', which is read", out="results"
            )


def _texts(typed: Iterable[object]) -> list[str]:
    """Return what was typed as text, of options that take several values each of them."""
    every = (
        part for each in typed for part in (each if isinstance(each, list | tuple) else [each])
    )
    return [part for part in every if isinstance(part, str)]


def _is_file(text: str) -> bool:
    with suppress(OSError, ValueError):  # a text that is no path: too long, or with a zero in it
        return Path(text).is_file()
    return False


def _files(question: Question, given: Mapping[str, Any]) -> list[str]:
    """Return the files that were typed, in the order of the options."""
    named = (each.name for each in question.options if each.argument.metavar == "FILE")
    return [text for text in _texts(map(given.get, named)) if text]


def _asked(function: Callable[..., Any], given: Mapping[str, Any]) -> Any:  # noqa: ANN401 - the result of any question
    """Return the answer to a question; an argument that takes any number of values by position is
    handed over as such.
    """
    listed = [
        each.name
        for each in inspect.signature(function).parameters.values()
        if each.kind is each.VAR_POSITIONAL
    ]
    by_name = {name: value for name, value in given.items() if name not in listed}
    return function(*(value for name in listed for value in given.get(name) or ()), **by_name)


def _show(
    results: list[Result], written: list[Path], common: Mapping[str, Any], *, first_screens: bool
) -> None:
    """Print the figures, which are written already: a closed pipe must not cost the results."""
    begin_printing()
    if common["json"]:
        say_json(results[0].result() if len(results) == 1 else [each.result() for each in results])
    elif common["quiet"]:
        _show_answers(results)
    else:
        if first_screens:
            for each in results:
                each.summary(full=common["full"])
        _show_places(results, written, full=common["full"])
    failures = [each.failure for each in results if each.failure]
    for failure in dict.fromkeys(failures):
        say(f"lostmotion: {failure}", error=True)
    if failures:
        raise typer.Exit(1)


def _show_places(results: list[Result], written: list[Path], *, full: bool) -> None:
    """Print where the reports are."""
    figures = any(each.sheet.sections for each in results)
    more = f"{_GAP}--full prints every figure." if written and figures and not full else ""
    for each, folder in zip(results, map(_from_here, written), strict=False):
        lines = [each.outcome(folder), *each.further_files(folder)]
        if each is results[-1] and lines[0] and len(lines[0] + more) <= _LINE:
            lines[0], more = lines[0] + more, ""
        say("\n" + "\n".join(line for line in lines if line))
    if more:
        say(more.strip())


def _from_here(written: Path) -> Path:
    """Return a path as the user would type it: from the working folder where it lies in it."""
    here = Path.cwd()
    return written.relative_to(here) if written.is_relative_to(here) else written


def _show_answers(results: list[Result]) -> None:
    """Print the answer of each result on one line, and what makes it doubtful to standard error."""
    for sheet in (each.sheet for each in results):
        for warning in sheet.warnings:
            say(f"warning: {warning}", error=True)
        if sheet.verdict:
            say(sheet.verdict)


def _folder(question: Question, given: Mapping[str, Any]) -> str | None:
    """Return the folder for results where none was named: NAME is that of the first file."""
    if not question.folder:
        return None
    return results_folder(next(iter(_files(question, given)), question.name), question.folder)
