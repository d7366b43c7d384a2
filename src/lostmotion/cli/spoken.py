"""Mistakes in the words of the command line: laws and verbs name their arguments, `pose = 0`, and a terminal's user typed options, `--at 0`."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, get_args, get_type_hints

from typer.core import TyperGroup

from lostmotion.errors import InputError, Problem, nearest, shown

if TYPE_CHECKING:
    from collections.abc import Mapping

    import typer

# Arguments of the Python verbs that a command's option calls otherwise.
_CALLED: Final = {"run": {"pose": "at"}, "size": {"also": "poses_file"}}
_ASSIGNED: Final = re.compile(r'\b(?P<name>[a-z_]+) ?= ?(?P<value>"[^"]*"|[^\s,"({]+|[({].*)')
_PYTHON: Final = "lostmotion."


class Spoken(TyperGroup):
    """The commands, whose mistakes name options."""

    def invoke(self, ctx: typer.Context) -> Any:  # type: ignore[override]  # noqa: ANN401 - whatever a command gives
        """Carry the command out; where it refuses an argument, refuse the option that was typed. Raises InputError."""
        try:
            return super().invoke(ctx)
        except InputError as error:
            name = ctx.invoked_subcommand or ""
            command = self.get_command(ctx, name)
            typed = {} if command is None else options_of(command)
            typed |= {argument: typed[option] for argument, option in _CALLED.get(name, {}).items()}
            options = {argument: option for argument, option in typed.items() if option.name}
            raise InputError([spoken(problem, options) for problem in error.problems]) from error

    def resolve_command(self, ctx: typer.Context, args: list[str]) -> Any:  # type: ignore[override]  # noqa: ANN401 - Click's own class
        """Find the command that was typed. Raises InputError where there is none of this name."""
        word, known = args[0], self.list_commands(ctx)
        if word not in known:
            raise InputError([Problem("", "command", shown(word), "one of " + ", ".join(known), "lostmotion run arm.toml", nearest(word, known))])
        return super().resolve_command(ctx, args)


@dataclass(frozen=True, slots=True)
class Option:
    """What is typed for an argument, "--at", and whether it takes a number; no name where it is typed without one."""

    name: str
    number: bool = False


def options_of(command: Any) -> dict[str, Option]:  # noqa: ANN401 - Click's own class, of whichever Click typer brings
    """Which options does a command take, by argument?"""
    hints = get_type_hints(command.callback)
    numbers = {name for name, hint in hints.items() if {hint, *get_args(hint)} & {int, float}}
    return {str(param.name): Option(long_name(param), param.name in numbers) for param in command.params}


def long_name(param: Any) -> str:  # noqa: ANN401 - Click's own class
    """What is an option called, "--at"? Empty for what is typed without a name."""
    return next((each for each in param.opts if each.startswith("--")), "")


def spoken(problem: Problem, options: Mapping[str, Option]) -> Problem:
    """How is a mistake said to someone who typed these options, by argument? As it is, where it stands in a file."""
    if problem.file:
        return problem
    words = [(name, options.get(name.replace(" ", "_"))) for name in problem.key.split(", ")]
    return replace(problem, key=", ".join(option.name if option else name for name, option in words), example=_typed(problem.example, options))


def _typed(example: str, options: Mapping[str, Option]) -> str:
    """Write an example as it is typed; none where it is one for Python alone: a call, ends by axis, metres as a bare number, a share as text."""
    if example.startswith(_PYTHON):
        return ""
    for match in _ASSIGNED.finditer(example):
        option = options.get(match["name"])
        number = re.fullmatch(r"-?[\d.]+(e-?\d+)?", match["value"]) is not None
        if option and (match["value"][0] in "({" or (option.number and not number) or (number and "." in match["value"] and not option.number)):
            return ""

    def one(match: re.Match[str]) -> str:
        option = options.get(match["name"])
        value = match["value"]
        return f"{option.name} {value if ' ' in value else value.strip(chr(34))}" if option else match[0]

    return re.sub(r",\s*(?=--)", " ", _ASSIGNED.sub(one, example))
