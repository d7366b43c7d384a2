"""What was typed and no option takes: said as every other mistake is, all at once."""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, Any, Final, get_args, get_type_hints

import typer
from typer.core import TyperCommand

from lostmotion.cli.spoken import long_name
from lostmotion.errors import InputError, Problem, nearest, shown

if TYPE_CHECKING:
    from collections.abc import Iterator

# The class of all mistakes in what was typed, of whichever Click typer brings.
_UsageError: Final[type[Exception]] = typer.BadParameter.__mro__[1]


class Typed(TyperCommand):
    """A command that refuses what was typed with what was found, what is expected and an example."""

    def parse_args(self, ctx: typer.Context, args: list[str]) -> list[str]:  # type: ignore[override]
        """Read the words typed. Raises InputError with every one that cannot be used."""
        typed = list(args)
        try:
            return super().parse_args(ctx, args)  # type: ignore[arg-type, unused-ignore]
        except _UsageError as error:
            problems = list(_problems(self, ctx, typed, error))
            if not problems:
                raise
            raise InputError(problems) from error


def _problems(command: Any, ctx: typer.Context, typed: list[str], error: Exception) -> Iterator[Problem]:  # noqa: ANN401 - Click's own class
    try:
        values, left, _ = command.make_parser(ctx).parse_args(args=list(typed))
    except _UsageError:
        yield _unreadable(command, ctx, error)
        return
    for param in command.get_params(ctx):
        try:
            if not param.is_eager:
                param.handle_parse_result(ctx, values, [])
        except _UsageError:
            value = values.get(param.name)
            expected, example, words = _takes(command, ctx, param)
            found = "nothing" if value is None else shown(value)
            yield Problem("", _name(param), found, expected, example, nearest(value, words) if isinstance(value, str) else "")
    if left:
        yield Problem("", ctx.command_path, shown(" ".join(left)), "nothing more; what has spaces stands in quotes", '"x 0.2..0.5 m"')


def _unreadable(command: Any, ctx: typer.Context, error: Exception) -> Problem:  # noqa: ANN401 - Click's own class
    """Say which option there is not, which lacks its value, or which switch was given one."""
    option = str(getattr(error, "option_name", ""))
    params = {name: param for param in command.get_params(ctx) for name in param.opts}
    if option not in params:
        meant = nearest(option, params)
        example = _takes(command, ctx, params[meant])[1] if meant else ""
        known = f"an option that {ctx.command_path} --help lists"
        return Problem("", ctx.command_path, shown(option) if option else str(error), known, example, meant)
    if getattr(params[option], "is_flag", False):
        return Problem("", option, "a value", "the option alone: it is a switch", option)
    expected, example, _ = _takes(command, ctx, params[option])
    return Problem("", option, "nothing after it", expected, example)


def _name(param: Any) -> str:  # noqa: ANN401 - Click's own class
    return long_name(param) or str(param.name)


def _takes(command: Any, ctx: typer.Context, param: Any) -> tuple[str, str, list[str]]:  # noqa: ANN401 - Click's own classes
    """What does an option or argument take: in words, as an example, and which words if no others?"""
    hint = get_type_hints(command.callback, include_extras=True).get(param.name)
    kind, about = _plain(hint), next(iter(getattr(hint, "__metadata__", ())), None)
    default = param.default.value if isinstance(param.default, Enum) else param.default
    if isinstance(kind, type) and issubclass(kind, Enum):
        words = [str(each.value) for each in kind]
        return "one of " + ", ".join(words), f"{_name(param)} {default or words[0]}", words
    if kind in {int, float}:
        low, high = getattr(about, "min", None), getattr(about, "max", None)
        ends = {(True, True): f" from {low} to {high}", (True, False): f", at least {low}", (False, True): f", at most {high}", (False, False): ""}
        expected = ("a whole number" if kind is int else "a number") + ends[low is not None, high is not None]
        example = next((each for each in (default, low, high) if each is not None), 1)
        return expected, f"{_name(param)} {example}", []
    example = f"{ctx.command_path} arm.toml" if param.name == "file" else f"{_name(param)} {default}" if default else ""
    return str(param.help or "a value"), example, []


def _plain(hint: Any) -> Any:  # noqa: ANN401 - any annotation
    """Give the type that one value has, out of its annotation, option or list."""
    while get_args(hint):
        hint = next(each for each in get_args(hint) if each is not type(None))
    return hint
