"""What a field of a model takes: the alternatives, in words, and an example that passes."""

from __future__ import annotations

import types
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Union, get_args, get_origin

from pydantic import BaseModel

from lostmotion.distribution_table import Distribution
from lostmotion.errors import Worded
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Iterable

Options = list[Any]
_PLAIN_WORDS: Final = {
    str: "text",
    float: "a finite number",
    int: "a whole number",
    bool: "true or false",
}
_ORIGIN: Final = frozenset({"preset", "assumed", "source", "upper_limits"})


def options_of(annotation: Any, marks: Iterable[Any] = ()) -> Options:  # noqa: ANN401 - any annotation
    """Return the alternatives that an annotation allows. Quantities, models, lists and plain types;
    unions opened, without None.
    """
    quantities: Options = [mark for mark in marks if isinstance(mark, Quantity | Distribution)]
    if quantities:
        return quantities
    worded = [mark for mark in marks if isinstance(mark, Worded)]
    if worded:
        return worded + options_of(annotation)
    origin = _origin(annotation)
    if origin is Annotated:
        inner, *metadata = get_args(annotation)
        return options_of(inner, metadata)
    if origin in (Union, types.UnionType):
        return [
            option for alternative in get_args(annotation) for option in options_of(alternative)
        ]
    return [] if annotation is type(None) else [annotation]


def _origin(annotation: Any) -> Any:  # noqa: ANN401 - any annotation
    return get_origin(annotation)


def models(options: Options) -> list[type[BaseModel]]:
    """Return those alternatives that are tables."""
    return [
        option for option in options if isinstance(option, type) and issubclass(option, BaseModel)
    ]


def tag(model: type[BaseModel]) -> str:
    """Return the value of `kind` or `type` that selects this table. Empty where none does."""
    fields = [model.model_fields[name] for name in ("kind", "type") if name in model.model_fields]
    return next((word for field in fields for word in literals([field.annotation])), "")


def keys(model: type[BaseModel]) -> list[str]:
    """Return the keys of this table. Those that say where its values come from last."""
    return sorted(model.model_fields, key=_ORIGIN.__contains__)


def literals(options: Options) -> list[str]:
    """Return the allowed words."""
    named = [
        word for option in options if isinstance(option, Distribution) for word in option.words
    ]
    return [
        *named,
        *(
            str(word)
            for option in options
            if _origin(option) is Literal
            for word in get_args(option)
        ),
    ]


def inside(options: Options, item: str | int) -> Options:
    """Return the alternatives one step further in: under a key, or at a position of a list."""
    if isinstance(item, str):
        fields = [
            model.model_fields[item] for model in models(options) if item in model.model_fields
        ]
        # a table of free keys
        named = [get_args(option)[1] for option in options if _origin(option) is dict]
        return [
            option for field in fields for option in options_of(field.annotation, field.metadata)
        ] + [option for annotation in named for option in options_of(annotation)]
    out: Options = []
    for option in options:
        origin = _origin(option)
        members = get_args(option)
        if origin in (tuple, list):
            out += options_of(
                members[item] if item < len(members) and members[-1] is not Ellipsis else members[0]
            )
    return out


def words(options: Options) -> str:
    """Describe what is allowed."""
    worded = [option.expected for option in options if isinstance(option, Worded)]
    return " or ".join(worded or dict.fromkeys(_words(option) for option in options))


def _words(option: Any) -> str:  # noqa: ANN401 - any annotation
    if isinstance(option, Quantity | Distribution):
        return option.expected
    origin = _origin(option)
    members = get_args(option)
    if origin is Literal:
        return ("one of " if len(members) > 1 else "") + ", ".join(map(_literal, members))
    if origin is tuple and members[-1] is not Ellipsis:
        return f"a list of {len(members)}, each {words(options_of(members[0]))}"
    if origin in (tuple, list):
        return f"a list, each {words(options_of(members[0]))}"
    return _PLAIN_WORDS.get(option, "a table")


def _literal(word: object) -> str:
    """Return a word or a truth value as it stands in a file."""
    return str(word).lower() if isinstance(word, bool) else f'"{word}"'


def example(options: Options) -> str:
    """Return one example that passes, as it stands in a file."""
    first = options[0] if options else Worded("", '"..."')
    return first.example if isinstance(first, Worded) else _example(first)


def _example(option: Any) -> str:  # noqa: ANN401 - any annotation
    if isinstance(option, Quantity | Distribution):
        plain = isinstance(option, Quantity) and not option.si and option.example.isdecimal()
        return option.example if plain else f'"{option.example}"'
    origin = _origin(option)
    members = get_args(option)
    if origin is Literal:
        return _literal(members[0])
    if origin is tuple and members[-1] is not Ellipsis:
        return "[" + ", ".join(example(options_of(member)) for member in members) + "]"
    if origin in (tuple, list):
        return f"[{example(options_of(members[0]))}]"
    if models([option]):
        return _example_table(option)
    return {float: "1.0", int: "1", bool: "true"}.get(option, '"text"')


def _example_table(model: type[BaseModel]) -> str:
    needed = [
        name
        for name, field in model.model_fields.items()
        if field.is_required() or name in ("kind", "type", *getattr(model, "in_example", ()))
    ]
    needed = needed or keys(model)[:1]
    return "{ " + ", ".join(f"{name} = {example(inside([model], name))}" for name in needed) + " }"
