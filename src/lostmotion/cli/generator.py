"""One command per question, generated from its signature."""

from __future__ import annotations

import contextlib
import inspect
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer
from typer.core import TyperCommand

from lostmotion.analyses.signature import QuestionParameter, question_of
from lostmotion.cli.answering import answer
from lostmotion.cli.shared_options import SHARED, shared_options
from lostmotion.errors import InputError, Problem, nearest, shown
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from lostmotion.analyses.signature import Question

# The class of all mistakes in what was typed, of whichever Click typer brings.
_UsageError: Final[type[Exception]] = typer.BadParameter.__mro__[1]


def command_of(function: Callable[..., Any]) -> Any:  # noqa: ANN401 - a command of whichever Click typer brings
    """Return the command that asks this question."""
    question = question_of(function)

    def carry_out(**typed: Any) -> None:  # noqa: ANN401 - as declared below
        try:
            answer(function, question, typed)
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


def _declared(question: Question, parameter: QuestionParameter) -> inspect.Parameter:
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


def _words_of(parameter: QuestionParameter) -> Callable[[str], list[str]] | None:
    """Return what completes a value in a shell: the words that an option takes. None for other
    options, which the shell completes by file names.
    """
    return (
        (lambda incomplete: [word for word in parameter.words if word.startswith(incomplete)])
        if parameter.words
        else None
    )


def _is_positional(question: Question, parameter: QuestionParameter) -> bool:
    """Return whether a parameter is typed without its name: the first one is."""
    return bool(question.options) and parameter is question.options[0]


def _positional(parameter: QuestionParameter) -> str:
    return parameter.name.upper() if parameter.required else f"[{parameter.name.upper()}]"


def _option(name: str) -> str:
    return "--" + name.replace("_", "-")


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
            f"nothing more: values stand behind an option that {ctx.command_path} --help lists, "
            "those with spaces in quotes",
            _placed(" ".join(left), known),
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


def _placed(text: str, known: Mapping[str, QuestionParameter]) -> str:
    """Return the first of these options that takes a value like this text, with it; of others any
    option.
    """
    for option, parameter in known.items():
        read = parameter.argument.read
        if isinstance(read, Quantity) and read.si:
            with contextlib.suppress(InputError):
                parameter.read(text, {})
                return f'{option} "{text}"' if " " in text else f"{option} {text}"
    return '--zone "x 0.2..0.5 m"' if "--zone" in known else "--out folder"


def _example(option: str, parameter: QuestionParameter) -> str:
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
