"""One command per question, generated from its signature, and the options that every command
has.
"""

from __future__ import annotations

import inspect
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import typer
from typer.core import TyperCommand

from lostmotion.analyses.signature import Argument, Parameter, question_of, results_folder
from lostmotion.cli.terminal import begin_printing, say, say_json
from lostmotion.errors import InputError, Problem, nearest, refuse_argument, shown

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from lostmotion.analyses.result import Result
    from lostmotion.analyses.signature import Question

# Columns of a line that every terminal shows whole, and the gap between two statements on it.
_LINE: Final = 80
_GAP: Final = "   "
STOPPED: Final = 130  # the shell's own code for it
stopped: list[bool] = []
# where they could not be raised: what was computed since is not to be trusted
swallowed: list[MemoryError] = []
# What every command has besides the arguments of its question.
SHARED: Final = (
    Parameter(
        "out",
        str,
        Argument(
            "Folder for report.html, result.json and what else the command writes.",
            metavar="FOLDER",
        ),
        None,
    ),
    Parameter(
        "figures",
        Literal["svg", "pdf", "png"],
        Argument("Also write every figure of the report as a file into FOLDER/figures."),
        None,
    ),
    Parameter(
        "tables",
        Literal["csv", "latex"],
        Argument("Also write every table as a file into FOLDER/tables; LaTeX for booktabs."),
        None,
    ),
    Parameter("force", bool, Argument("Replace an existing output folder."), default=False),
    Parameter(
        "json",
        bool,
        Argument(
            "Print result.json in place of the figures; then a folder is written only where "
            "--out names one."
        ),
        default=False,
    ),
    Parameter("full", bool, Argument("Print every figure in place of one screen."), default=False),
    Parameter("quiet", bool, Argument("Print the answer alone, on one line."), default=False),
)
# What a command has whose result is data that it states in words.
_AS_JSON: Final = Parameter("json", bool, Argument("Print the result as JSON."), default=False)
# Of these, what replaces the one screen that is printed, and what a report's folder holds besides
# the report.
_PRINTED: Final = ("json", "full", "quiet")
_COPIES: Final = frozenset({"figures", "tables"})
# The class of all mistakes in what was typed, of whichever Click typer brings.
_UsageError: Final[type[Exception]] = typer.BadParameter.__mro__[1]


def command_of(function: Callable[..., Any]) -> Any:  # noqa: ANN401 - a command of whichever Click typer brings
    """Return the command that asks this question."""
    question = question_of(function)

    def carry_out(**typed: Any) -> None:  # noqa: ANN401 - as declared below
        try:
            _carry_out(function, question, typed)
        except InputError as error:
            raise InputError([spelled(problem, question) for problem in error.problems]) from error

    declared = [
        _declared(question, each) for each in (*question.options, *shared_options(question))
    ]
    vars(carry_out)["__signature__"] = inspect.Signature(declared)
    carry_out.__annotations__ = {each.name: each.annotation for each in declared}
    app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
    kind = type("_Asking", (_Command,), {"question": question})
    app.command(
        question.name,
        cls=kind,
        short_help=question.summary,
        help=f"{question.summary}\n\n{question.details}",
    )(carry_out)
    return typer.main.get_command(app)


def shared_options(question: Question) -> tuple[Parameter, ...]:
    """Return the options that a command has besides the arguments of its question: where its result
    is data alone, only one to print it as such.
    """
    own = {each.name for each in question.options}
    if question.folder is None:
        return () if question.in_words is None else (_AS_JSON,)
    own |= {"force"} if "out" in own else set()
    # what it writes is one file, and no report
    own |= _COPIES if "out" in own and not question.folder else set()
    return tuple(each for each in SHARED if each.name not in own)


def _declared(question: Question, parameter: Parameter) -> inspect.Parameter:
    """Return one option as typer declares it; all values are text, which the question reads."""
    about = parameter.argument
    kind: Any = str | None
    if parameter.is_switch:
        kind = bool
    elif about.repeats:
        kind = list[str] | None
    elif about.together > 1:
        kind = tuple[(str,) * about.together] | None  # type: ignore[misc]
    names = [_option(parameter.name), *about.aliases]
    metavar = None if parameter.is_switch else " ".join([parameter.metavar] * about.together)
    text = parameter.help
    if parameter.name == "out" and parameter in SHARED:
        text += (
            f" Default: NAME-{question.folder}."
            if question.folder
            else " Default: none is written."
        )
    shown_as = (
        typer.Argument(help=text, metavar=_positional(parameter), show_default=False)
        if _is_positional(question, parameter)
        else typer.Option(
            *names,
            help=text,
            metavar=metavar,
            show_default=False,
            autocompletion=_words_of(parameter),
        )
    )
    default = False if parameter.is_switch else None
    return inspect.Parameter(
        parameter.name,
        inspect.Parameter.KEYWORD_ONLY,
        default=default,
        annotation=Annotated[kind, shown_as],
    )


def _words_of(parameter: Parameter) -> Callable[[str], list[str]] | None:
    """Return what completes a value in a shell: the words that an option takes. None for other
    options, which the shell completes by file names.
    """
    return (
        (lambda incomplete: [word for word in parameter.words if word.startswith(incomplete)])
        if parameter.words
        else None
    )


def _is_positional(question: Question, parameter: Parameter) -> bool:
    """Return whether a parameter is typed without its name: the first one is."""
    return bool(question.options) and parameter is question.options[0]


def _positional(parameter: Parameter) -> str:
    return parameter.name.upper() if parameter.required else f"[{parameter.name.upper()}]"


def _option(name: str) -> str:
    return "--" + name.replace("_", "-")


def _carry_out(function: Callable[..., Any], question: Question, typed: Mapping[str, Any]) -> None:
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
            say(question.in_words(data))
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
    results = found if isinstance(found, list) else [found]
    copies = {name: common[name] for name in _COPIES if name in common}
    written = [
        each.report(None if own else out, force=force, **copies)
        for each in results
        if own or out is not None
    ]
    _show(results, written, common)


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


def _show(results: list[Result], written: list[Path], common: Mapping[str, Any]) -> None:
    """Print the figures, which are written already: a closed pipe must not cost the results."""
    begin_printing()
    if common["json"]:
        say_json(results[0].result() if len(results) == 1 else [each.result() for each in results])
    elif common["quiet"]:
        _show_answers(results)
    else:
        _show_figures(results, written, full=common["full"])
    failures = [each.failure for each in results if each.failure]
    for failure in dict.fromkeys(failures):
        say(f"lostmotion: {failure}", error=True)
    if failures:
        raise typer.Exit(1)


def _show_figures(results: list[Result], written: list[Path], *, full: bool) -> None:
    """Print one screen of each result, or every figure, and where the reports are."""
    for each in results:
        each.summary(full=full)
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
    files = [
        value
        for each in question.options
        if each.argument.metavar == "FILE" and (value := given.get(each.name))
    ]
    first = files[0] if files else question.name
    return results_folder(first if isinstance(first, str) else first[0], question.folder)


class _Command(TyperCommand):
    """A command that refuses what was typed with what was found, what is expected and an
    example.
    """

    question: Question

    def parse_args(self, ctx: typer.Context, args: list[str]) -> list[str]:  # type: ignore[override]
        """Read the words typed. Raises InputError for an option that there is not, one without its
        value, and words too many.
        """
        typed = list(args)
        try:
            return super().parse_args(ctx, args)  # type: ignore[arg-type, unused-ignore]
        except _UsageError as error:
            raise InputError(list(_problems(self, ctx, typed, error))) from error


def _problems(
    command: Any,  # noqa: ANN401
    ctx: typer.Context,
    typed: list[str],
    error: Exception,
) -> Iterator[Problem]:
    own = {name for each in command.params for name in each.opts}
    known = {
        name: each
        for each in (*command.question.options, *SHARED)
        for name in (_option(each.name), *each.argument.aliases)
        if name in own
    }
    option = str(getattr(error, "option_name", ""))
    if not option:
        _, left, _ = command.make_parser(ctx).parse_args(args=typed)
        yield Problem(
            "",
            ctx.command_path,
            shown(" ".join(left)),
            "nothing more; what has spaces stands in quotes",
            '"x 0.2..0.5 m"',
        )
    elif option not in known:
        near = nearest(option, known)
        example = _example(near, known[near]) if near else ""
        yield Problem(
            "",
            ctx.command_path,
            shown(option),
            f"an option that {ctx.command_path} --help lists",
            example,
            near,
        )
    elif known[option].is_switch:
        yield Problem("", option, "a value", "the option alone: it is a switch", option)
    else:
        found = (
            "too few values after it" if known[option].argument.together > 1 else "nothing after it"
        )
        yield Problem(
            "", option, found, known[option].argument.help, _example(option, known[option])
        )


def _example(option: str, parameter: Parameter) -> str:
    """Return an option with its default, or with the kind of its value."""
    if parameter.is_switch:
        return option
    return f"{option} {parameter.metavar if parameter.default in (None, ()) else parameter.default}"


def command_name(question: str) -> str:
    """Return a question's name as it is typed: an export is named after what it writes, in a word
    of its own.
    """
    return question.replace("export_", "export ")


def spelled(problem: Problem, question: Question) -> Problem:
    """Return a mistake as the command line spells it: arguments by their options, and an example
    that can be typed.
    """
    if problem.file:
        return problem
    known = {each.name: each for each in (*question.options, *SHARED)}
    first = question.options[0].name if question.options else ""
    names = [
        name if name not in known else name.upper() if name == first else _option(name)
        for name in problem.key.split(", ")
    ]
    example = problem.example or " ".join(
        f"lostmotion {command_name(question.name)} {value}"
        if name == first
        else _typed(name, value)
        for name, value in problem.passing
        if name in known
    )
    return replace(problem, key=", ".join(names), example=example, passing=())


def _typed(name: str, value: object) -> str:
    """Write an option with its value."""
    if value is True:
        return _option(name)
    values = value if isinstance(value, tuple) else (value,)
    return " ".join(
        [
            _option(name),
            *(
                f'"{each}"'
                if isinstance(each, str) and not each.replace("_", "").isalnum()
                else str(each)
                for each in values
            ),
        ]
    )
