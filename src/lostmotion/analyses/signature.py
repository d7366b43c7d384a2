"""Signature of a question: its arguments with their documentation, their units and how they are
read.

A question is a typed function, marked by `question`, each of whose arguments is `Annotated` with
one `Argument`. The parameter section of its docstring and the options of the command line come from
there.
"""

from __future__ import annotations

import functools
import inspect
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Integral
from pathlib import Path
from types import SimpleNamespace
from typing import (
    Annotated,
    Any,
    Final,
    ForwardRef,
    Literal,
    TypeAlias,
    TypeVar,
    cast,
    get_args,
    get_origin,
)

from lostmotion.analyses.quantities import Three, amount, three
from lostmotion.blas_threads import one_blas_thread
from lostmotion.errors import InputError, Problem, nearest, refuse_argument, shown
from lostmotion.units import Quantity

F = TypeVar("F", bound=Callable[..., Any])
# From the argument's name, what was given, and all arguments, those before it as read, to the value
# that is used.
Reader: TypeAlias = Callable[[str, Any, Mapping[str, Any]], Any]
_WIDTH: Final = 100
# A whole number as people type it; longer ones are none that an argument takes.
_WHOLE: Final = re.compile(r"[+-]?[0-9]{1,18}")
_KINDS: Final = {
    "m": "LENGTH",
    "rad": "ANGLE",
    "N": "FORCE",
    "N m": "TORQUE",
    "K": "TEMPERATURE",
    "s": "TIME",
    "N m/rad": "STIFFNESS",
    "kg": "MASS",
    "": "NUMBER",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class _Options:
    metavar: str = ""
    least: int | None = None
    most: int | None = None
    aliases: tuple[str, ...] = ()
    repeats: bool = False
    together: int = 1
    python_only: bool = False


@dataclass(frozen=True, slots=True)
class Argument(_Options):
    """Documentation of one argument, and how its value is read.

    help       what it means, with an example of its text where it takes text
    read       a quantity, three of them, or a function; None: whole numbers from `least` to `most`
               and words are checked, anything else is passed on
    metavar    kind of value that `--help` shows
    aliases    further options with the same meaning
    repeats    whether one or several values are taken
    together   how many values stand behind the option each time
    python_only      callbacks, which the command line has none of
    """

    help: str
    read: Quantity | Three | Reader | None = None


@dataclass(frozen=True, slots=True)
class QuestionParameter:
    """One parameter of a question: its name, its type without the annotation, and its default."""

    name: str
    type: Any
    argument: Argument
    default: Any

    @property
    def required(self) -> bool:
        """Return whether the question has no default for it."""
        return self.default is inspect.Parameter.empty

    @property
    def words(self) -> tuple[str, ...]:
        """Return the words that it takes; empty where it takes anything else."""
        kinds = (self.type, *get_args(self.type))
        return next((get_args(kind) for kind in kinds if get_origin(kind) is Literal), ())

    @property
    def is_switch(self) -> bool:
        """Return whether it is true or false."""
        return self.type is bool

    @property
    def metavar(self) -> str:
        """Return the kind of value for `--help`."""
        if self.argument.metavar or self.words:
            return self.argument.metavar or "|".join(self.words)
        if isinstance(self.argument.read, Quantity | Three):
            field = (
                self.argument.read.each
                if isinstance(self.argument.read, Three)
                else self.argument.read
            )
            return _KINDS[field.si]
        return "NUMBER" if self.type is int or int in get_args(self.type) else "TEXT"

    @property
    def help(self) -> str:
        """Return its documentation with its default."""
        if self.required or self.default in {None, (), False, ""}:
            return self.argument.help
        return f"{self.argument.help} Default: {self.default}."

    @property
    def type_text(self) -> str:
        """Return its type as `help()` shows it."""
        kinds = get_args(self.type) if isinstance(self.type, type(int | str)) else (self.type,)
        return " | ".join(_type_text(kind) for kind in kinds)

    def read(self, value: Any, given: Mapping[str, Any]) -> Any:  # noqa: ANN401 - whatever a user passes
        """Return the value as the question uses it. Raises InputError."""
        reader = self.argument.read
        if value is None and self.default is None:
            return None
        if isinstance(reader, Quantity):
            return amount(self.name, value, reader)
        if isinstance(reader, Three):
            return three(self.name, value, reader)
        if reader is not None:
            return reader(self.name, value, given)
        if self.words:
            return self._word(value)
        return self._whole(value) if self.type is int or int in get_args(self.type) else value

    def _word(self, value: object) -> str:
        if value in self.words:
            return str(value)
        example = self.default if self.default in self.words else self.words[0]
        near = nearest(value, self.words) if isinstance(value, str) else ""
        raise InputError(
            [
                Problem(
                    "",
                    self.name,
                    shown(value),
                    "one of " + ", ".join(self.words),
                    nearest=near,
                    passing=((self.name, example),),
                )
            ]
        )

    def _whole(self, value: object) -> int:
        least, most = self.argument.least, self.argument.most
        whole = whole_number(value)
        if (
            whole is not None
            and (least is None or whole >= least)
            and (most is None or whole <= most)
        ):
            return whole
        ends = (
            f" from {least} to {most}"
            if most is not None
            else ""
            if least is None
            else f", at least {least}"
        )
        example = next(
            each for each in (None if self.required else self.default, least, 1) if each is not None
        )
        raise refuse_argument(self.name, value, f"a whole number{ends}", **{self.name: example})


def whole_number(value: object) -> int | None:
    """Return a whole number, as such or as people type it; None for anything else."""
    if isinstance(value, str) and _WHOLE.fullmatch(value.strip()):
        return int(value)
    return int(value) if isinstance(value, Integral) and not isinstance(value, bool) else None


def _type_text(kind: Any) -> str:  # noqa: ANN401 - any annotation
    if isinstance(kind, ForwardRef):
        return kind.__forward_arg__
    return "None" if kind is type(None) else inspect.formatannotation(kind)


@dataclass(frozen=True, slots=True)
class Question:
    """What a question's function declares: its name on both sides, its text, its parameters, and
    the name of its results' folder.

    in_words  returns a result that is data alone as text for the command line; None where it is
              printed as JSON
    """

    name: str
    summary: str
    details: str
    parameters: tuple[QuestionParameter, ...]
    folder: str | None
    in_words: Callable[[Any], str] | None = None

    @property
    def options(self) -> tuple[QuestionParameter, ...]:
        """Return the parameters that the command line has."""
        return tuple(each for each in self.parameters if not each.argument.python_only)


def question(
    *, folder: str | None, in_words: Callable[[Any], str] | None = None
) -> Callable[[F], F]:
    """Mark a function as a question: every argument has its `Argument`, and its docstring gains a
    section with all of them.

    `folder`: what the results' folder is called behind the file's name; empty where none is written
    unless one is named, None where the result is data alone. `in_words`: returns such data as text
    for the command line; without it JSON is printed.
    """

    def mark(function: F) -> F:
        signature = inspect.signature(function)

        def arguments() -> None: ...

        arguments.__annotations__ = {
            name: each.annotation for name, each in signature.parameters.items()
        }
        hints = inspect.get_annotations(arguments, globals=function.__globals__, eval_str=True)
        parameters = tuple(
            _parameter(name, hints[name], each.default)
            for name, each in signature.parameters.items()
        )
        text = inspect.cleandoc(function.__doc__ or "")
        sections = re.search(r"^\w+\n---", text, re.MULTILINE)
        first = len(text) if sections is None else sections.start()
        summary, _, details = text[:first].strip().partition("\n\n")
        asked = Question(
            function.__name__, " ".join(summary.split()), details, parameters, folder, in_words
        )
        function.__doc__ = "\n\n".join(
            part for part in (text[:first].strip(), _section(parameters), text[first:]) if part
        )
        plain = [
            each.replace(annotation=found.type_text)
            for each, found in zip(signature.parameters.values(), parameters, strict=True)
        ]

        @functools.wraps(function)
        def answer(*given: Any, **named: Any) -> Any:  # noqa: ANN401 - as the function
            with one_blas_thread():
                return function(*given, **named)

        vars(answer).update(question=asked, __signature__=signature.replace(parameters=plain))
        return cast("F", answer)

    return mark


def results_folder(file: str | Path, folder: str) -> str:
    """Return the folder for results of this file where none was named, such as "NAME-accuracy"."""
    return f"{Path(file).stem}-{folder}"


def question_of(function: Callable[..., Any]) -> Question:
    """Return what `question` found in a function's signature."""
    found: Question = vars(function)["question"]
    return found


def _parameter(name: str, hint: Any, default: Any) -> QuestionParameter:  # noqa: ANN401 - any annotation
    optional = get_origin(hint) is not Annotated  # an argument of its own, or None
    annotated = next(
        (each for each in (hint, *get_args(hint)) if get_origin(each) is Annotated), None
    )
    if annotated is None or not isinstance(annotated.__metadata__[0], Argument):
        raise TypeError(f"the argument '{name}' of a question has no Argument")
    kind = annotated.__origin__
    return QuestionParameter(
        name,
        kind | None if optional and not isinstance(kind, ForwardRef) else kind,
        annotated.__metadata__[0],
        default,
    )


def _section(parameters: Sequence[QuestionParameter]) -> str:
    lines = ["Parameters", "----------"]
    for each in parameters:
        lines += [
            f"{each.name} : {each.type_text}",
            *textwrap.wrap(each.help, _WIDTH, initial_indent="    ", subsequent_indent="    "),
        ]
    return "\n".join(lines)


def read_arguments(function: Callable[..., Any], given: Mapping[str, Any]) -> Any:  # noqa: ANN401 - one attribute per argument
    """Return the arguments of a question as it uses them, one attribute each; a callback that was
    not given does nothing.

    `given` holds every argument by name, as `locals()` at the question's beginning. Raises
    InputError with the mistakes of all arguments.
    """
    values = dict(given)
    problems: dict[Problem, None] = {}
    for each in question_of(function).parameters:
        try:
            values[each.name] = each.read(values[each.name], values)
        except InputError as mistake:
            problems |= dict.fromkeys(mistake.problems)
    if problems:
        raise InputError(list(problems))
    return SimpleNamespace(
        **{"ready": _nothing}
        | {name: value for name, value in values.items() if name != "ready" or value is not None}
    )


def _nothing() -> None:
    """Wait for nobody."""
