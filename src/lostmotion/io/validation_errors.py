"""From pydantic's account of what is wrong to the user's: the key as written, what was found, what
belongs there, an example that passes.

Pydantic names a spot by fields, list positions, and the labels of the alternatives it tried.
Walking the model along that path finds the labels from the user's own keys, and says what the spot
takes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

from lostmotion.errors import Problem, shown
from lostmotion.io.field_schema import example, inside, keys, literals, models, tag, words
from lostmotion.io.limits import MOST_MISTAKES, nearest
from lostmotion.parts.error_source import Part

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from pydantic import BaseModel, ValidationError

    Also = Mapping[type[BaseModel], Mapping[str, str]]

Path: TypeAlias = tuple[str | int, ...]
# Of pydantic's errors; many of them can be one mistake of the user's.
_MOST_ERRORS: Final = 2000


class _Described(NamedTuple):
    """A mistake as text, without its file."""

    path: Path
    found: str
    expected: str
    example: str
    near: str = ""


@dataclass
class _KeyPlace:
    """One error: pydantic's details, the user's path, what is allowed at each step of it, and where
    alternatives forked, if they did.
    """

    detail: Any
    path: Path
    trail: list[list[Any]]
    fork: int | None = None

    @property
    def last(self) -> str:
        return str(self.path[-1]) if self.path else ""

    @property
    def context(self) -> dict[str, Any]:
        found: dict[str, Any] = self.detail.get("ctx", {})
        return found

    @property
    def given(self) -> Any:  # noqa: ANN401 - whatever a file holds
        return self.detail["input"]


def problems(
    error: ValidationError,
    model: type[BaseModel],
    file: str,
    key_of: Callable[[Path], str],
    also: Also | None = None,
) -> list[Problem]:
    """Return the user's mistakes. One Problem per mistake, whatever the number of alternatives that
    pydantic tried.

    `key_of` gives the key as the user wrote it; `also` gives keys that the file format takes
    besides a model's fields, with an example of each.
    """
    spots = [
        _spot(detail, model)
        for detail in error.errors(include_url=False)[:_MOST_ERRORS]
        if not _is_echo(detail)
    ]
    forks: dict[Path, list[_KeyPlace]] = {}
    for spot in spots:
        if spot.fork is not None:
            forks.setdefault(spot.path[: spot.fork], []).append(spot)
    out: dict[Problem, None] = {}
    for spot in spots:
        if len(out) > MOST_MISTAKES:
            break
        together = [spot] if spot.fork is None else forks.pop(spot.path[: spot.fork], [])
        for chosen in _of_one_alternative(together):
            found = _DESCRIBE.get(chosen.detail["type"], _describe_value)(chosen, also or {})
            out[
                Problem(
                    file, key_of(found.path), found.found, found.expected, found.example, found.near
                )
            ] = None
    return list(out)


def _is_echo(detail: Any) -> bool:  # noqa: ANN401 - pydantic's error details
    """Return whether a list only seems too short because pydantic dropped its faulty members."""
    least = detail.get("ctx", {}).get("min_length", 0)
    return (
        detail["type"] == "too_short"
        and isinstance(detail["input"], list)
        and len(detail["input"]) >= least
    )


def _of_one_alternative(together: list[_KeyPlace]) -> list[_KeyPlace]:
    """Keep the errors of the alternative that fits what was written; where none does, one error
    that names all alternatives.
    """
    deeper = [spot for spot in together if spot.fork is not None and len(spot.path) > spot.fork]
    if deeper or len(together) <= 1:
        return deeper or together
    reasoned = [spot for spot in together if "why" in spot.context]
    # a table is meant as the alternative that takes tables, whose own rule it breaks
    of_table = [
        spot
        for spot in reasoned
        if isinstance(spot.given, dict) and spot.detail["type"] != "quantity"
    ]
    return [*of_table, *reasoned, together[0]][:1]


def _spot(detail: Any, model: type[BaseModel]) -> _KeyPlace:  # noqa: ANN401 - pydantic's error details
    spot = _KeyPlace(detail, (), [[model]])
    for index, item in enumerate(detail["loc"]):
        here = spot.trail[-1]
        further = inside(here, item)
        tagged = [option for option in models(here) if tag(option) == item]
        is_key = index == len(detail["loc"]) - 1 and detail["type"] in (
            "missing",
            "extra_forbidden",
        )
        if tagged and len(models(here)) > 1:  # also where a key has the name of its kind: rigid
            spot.trail[-1] = tagged
        elif further or is_key:
            spot.path = (*spot.path, item)
            spot.trail.append(further)
        elif tagged:
            spot.trail[-1] = tagged
        elif spot.fork is None:
            spot.fork = len(spot.path)
    return spot


def _describe_value(spot: _KeyPlace, _: Also) -> _Described:
    allowed = spot.trail[-1]
    why = f" ({spot.context['why']})" if "why" in spot.context else ""
    near = nearest(spot.given, literals(allowed)) if isinstance(spot.given, str) else ""
    return _Described(
        spot.path,
        shown(spot.given) + why,
        words(allowed),
        _assignment(spot.path, f'"{near}"' if near else example(allowed)),
        near,
    )


def _describe_rule(spot: _KeyPlace, _: Also) -> _Described:
    """Describe a breach of a part's own rule, whose error carries the words; without a reason, what
    the file states is the reason.
    """
    shape = spot.context["example"]
    example = shape if "=" in shape else _assignment(spot.path, shape)
    found = spot.context.get("why", shown(spot.given))
    return _Described(
        (*spot.path, *spot.context.get("path", ())),
        found,
        spot.context["expected"],
        example,
        spot.context.get("near", ""),
    )


def _describe_missing(spot: _KeyPlace, _: Also) -> _Described:
    if isinstance(spot.path[-1], int):  # speak of the short list, not of the hole in it
        path, allowed = spot.path[:-1], spot.trail[-2]
        return _Described(
            path, shown(spot.given), words(allowed), _assignment(path, example(allowed))
        )
    return _Described(
        spot.path, "nothing", words(spot.trail[-1]), _assignment(spot.path, example(spot.trail[-1]))
    )


def _describe_unknown(spot: _KeyPlace, also: Also) -> _Described:
    owners = models(spot.trail[-2])
    absent = next(
        (
            owner.not_modelled[spot.last]
            for owner in owners
            if issubclass(owner, Part) and spot.last in owner.not_modelled
        ),
        None,
    )
    if absent:
        return _Described(spot.path, f"an unknown key with {shown(spot.given)}", *absent)
    examples = {
        name: f"{name} = {example(inside([owner], name))}"
        for owner in owners
        for name in keys(owner)
    }
    for owner in owners:
        examples |= also.get(owner, {})
    near = nearest(spot.last, examples)
    plain = (
        isinstance(spot.given, str) and spot.given.isprintable() and not {'"', "\\"} & {*spot.given}
    )
    if near and plain and examples[near].startswith(f"{near} = {{"):
        # the name of a table, rather than an empty table
        examples[near] = f'{near} = "{spot.given}"'
    found = f"an unknown key with {shown(spot.given)}"
    return _Described(
        spot.path,
        found,
        "one of " + ", ".join(examples),
        examples[near or next(iter(examples))],
        near,
    )


def _describe_tag(spot: _KeyPlace, _: Also) -> _Described:
    name = spot.context["discriminator"].strip("'")
    tags = [tag(option) for option in models(spot.trail[-1])]
    stated = spot.context.get("tag")
    near = nearest(str(stated or ""), tags)
    found = "nothing" if stated is None else shown(stated)
    return _Described(
        (*spot.path, name),
        found,
        "one of " + ", ".join(f'"{each}"' for each in tags),
        f'{name} = "{near or tags[0]}"',
        near,
    )


def _describe_count(spot: _KeyPlace, _: Also) -> _Described:
    least, most = spot.context.get("min_length"), spot.context.get("max_length")
    of = "characters" if isinstance(spot.given, str) else "entries"
    expected = f"at least {least} {of}" if most is None else f"at most {most} {of}"
    return _Described(
        spot.path,
        f"{len(spot.given)} {of}",
        f"{words(spot.trail[-1])}, {expected}",
        _assignment(spot.path, example(spot.trail[-1])),
    )


_DESCRIBE: Final[dict[str, Callable[[_KeyPlace, Also], _Described]]] = {
    "missing": _describe_missing,
    "extra_forbidden": _describe_unknown,
    "union_tag_invalid": _describe_tag,
    "union_tag_not_found": _describe_tag,
    "too_short": _describe_count,
    "too_long": _describe_count,
    "string_too_short": _describe_count,
    "string_too_long": _describe_count,
    # raised by the parts themselves
    **dict.fromkeys(
        (
            "direction",
            "limits",
            "section",
            "zones",
            "lost_motion",
            "names",
            "line",
            "gearbox",
            "rising",
        ),
        _describe_rule,
    ),
}


def _assignment(path: Path, value: str) -> str:
    """Show the value behind its key, as it would stand in the file."""
    return f"{path[-1]} = {value}" if path and isinstance(path[-1], str) else value
