"""Values of a part, or of a whole arm, that are only known to lie in a range: found, drawn, and
replaced by one value each.

A range states ignorance: the value is the same for every gearbox or robot of a study. One draw of
all ranges gives a part with known values, on which everything can be computed as usual; a study
repeated over such draws shows how far its results depend on what is not known.

A range belongs to the part that states it. Equal parts of an arm share its value, such as one
drawing on several joints. A material shares it wherever it is used under one name: it is one batch.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, TypeAlias, TypeVar

import numpy as np
from pydantic import BaseModel, ValidationError

from lostmotion.band import Band
from lostmotion.errors import InputError, Problem
from lostmotion.parts.error_source import Part
from lostmotion.parts.material import Material
from lostmotion.units import Toleranced

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from lostmotion.spatial import Floats

P = TypeVar("P", bound=Part)
# Number of draws: the 5th and 95th percentile have three draws beyond them.
DRAWS: Final = 64
# Limits of a band: probabilities of a smaller value.
BAND: Final = (0.05, 0.95)
# Relative change of a result that is rounding.
_ROUNDING: Final = 1e-9
# Steps of a path: the joints of an arm, and what a drawing leaves open.
_JOINTS: Final = "joints"
_UNSTATED: Final = "unstated"
Path: TypeAlias = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class UnknownValue:
    """A value that is only known to lie in a range: its key ("output_pins.diameter",
    "materials.onyx.young"), and the range in SI.

    name  as the file names it ("gearboxes.RV.output_pins.diameter", "output_pins.diameter of the
          gearbox of A", "frame of gearboxes.RV (not stated)")
    """

    key: str
    band: Band
    name: str = ""


def unknown_values(part: Part) -> tuple[UnknownValue, ...]:
    """Return the values of a part, and of the parts that it consists of, that are only known to lie
    in a range, in order of their keys.

    A value that several places share is listed once, under the first of them.
    """
    found: dict[object, UnknownValue] = {}

    def visit(place: _Place, band: Band) -> Band:
        found.setdefault(place.identity, UnknownValue(place.key, band, place.name))
        return band

    _walk(part, visit)
    return tuple(sorted(found.values(), key=lambda each: each.key))


def with_values(part: P, values: Mapping[str, float], keys: Sequence[str] | None = None) -> P:
    """Return the part with known values (key to SI) in place of the ranges of `unknown_values`.

    The parts that change are rebuilt and checked, so that no result computed for other values
    remains. Raises InputError where these values make an impossible part, and KeyError without the
    value of a range.

    keys  of the ranges in the order in which they are found, where many values are set; default:
          found here
    """
    order = iter(_keys(part) if keys is None else keys)
    try:
        out = _walk(part, lambda _place, _band: values[next(order)])
    except ValidationError as error:
        raise _impossible(error, values) from None
    if not isinstance(out, type(part)):
        raise TypeError(f"{type(part).__name__} became {type(out).__name__}")
    return out


def _keys(part: Part) -> list[str]:
    """Return the key of each range of a part in the order in which a walk finds them: that of the
    first place that shares its value.
    """
    keys: dict[object, str] = {}
    found: list[str] = []

    def visit(place: _Place, band: Band) -> Band:
        found.append(keys.setdefault(place.identity, place.key))
        return band

    _walk(part, visit)
    return found


def draws(part: P, unknown: tuple[UnknownValue, ...], shares: Floats) -> Iterator[P]:
    """Yield the part with known values at each row of shares (draw, value), between 0 and 1; errors
    as `with_values`.
    """
    keys = _keys(part)
    for row in shares.tolist():
        yield with_values(
            part,
            {each.key: each.band.at(share) for each, share in zip(unknown, row, strict=True)},
            keys,
        )


def latin_hypercube(unknown: tuple[UnknownValue, ...], draws: int = DRAWS, seed: int = 1) -> Floats:
    """Return the shares (draw, value), each between 0 and 1, at which to take the ranges: a Latin
    hypercube of the middles of equal intervals.

    So a result that depends on one range alone has its exact quantiles. The order of a value's
    draws follows from its key and the seed: other ranges do not change it. Source: M. McKay, R.
    Beckman, W. Conover, Technometrics 21 (1979) 239; with middles instead of random places in the
    intervals.
    """
    columns = [
        np.random.default_rng([seed, zlib.crc32(each.key.encode())]).permutation(draws)
        for each in unknown
    ]
    return (np.array(columns, dtype=float).reshape(len(unknown), draws).T + 0.5) / draws


def band(values: Floats) -> tuple[float, float]:
    """Return the 5th and the 95th percentile of values (draw,); draws stand for equal intervals of
    probability, each for the middle of its own.
    """
    low, high = np.quantile(values, BAND, method="hazen")
    return float(low), float(high)


def varies(values: Floats) -> bool:
    """Return whether a result (draw,) changes beyond rounding."""
    return bool(np.ptp(values) > _ROUNDING * np.abs(values).max())


def influence(shares: Floats, values: Floats) -> Floats:
    """Return the share (value,) of the variance of a result (draw,) that each range explains alone:
    the squared correlation of ranks.

    shares  (draw, value) where in its range each value is taken, as of `latin_hypercube`

    Zero for a result that does not change beyond rounding.
    """
    if not varies(values):
        return np.zeros(shares.shape[1])
    ranks = np.argsort(np.argsort(values, kind="stable")) / len(values)
    ranks = ranks - ranks.mean()
    own = shares - shares.mean(axis=0)
    return np.asarray((own.T @ ranks) ** 2 / ((own**2).sum(axis=0) * (ranks @ ranks)))


@dataclass(frozen=True, slots=True)
class _Place:
    """Where a value stands: its path, and the part whose equals share it, with the path of that
    part.
    """

    path: Path
    owner: Part | None = None
    start: int = 0

    def inside(self, step: str) -> _Place:
        return _Place((*self.path, step), self.owner, self.start)

    @property
    def within(self) -> Path:
        return self.path[self.start :]

    @property
    def identity(self) -> object:
        """Return what is equal for places that share a value."""
        return (
            self.path if self.owner is None else (type(self.owner), repr(self.owner), self.within)
        )

    @property
    def key(self) -> str:
        named = isinstance(self.owner, Material) and bool(self.owner.name)
        steps = (
            ("materials", self.owner.name, *self.within)
            if isinstance(self.owner, Material) and named
            else self.path
        )
        return ".".join(steps)

    @property
    def name(self) -> str:
        shared = self.owner.shared_name if self.owner is not None else ""
        if self.key != ".".join(self.path):  # of a named material
            return self.key
        part, within = shared, self.within
        if not shared and self.path[:1] == (_JOINTS,):
            _, joint, *kind = self.path[: self.start] if self.start else self.path[:-1]
            part = " of ".join([*(f"the {step}" for step in reversed(kind)), joint])
            within = self.within if self.start else self.path[-1:]
        if within[:1] == (_UNSTATED,):
            return f"{'.'.join(within[1:])}{f' of {part}' if part else ''} (not stated)"
        return (
            ".".join((shared, *within))
            if shared
            else f"{'.'.join(within)}{f' of {part}' if part else ''}"
        )


_ROOT: Final = _Place(())
# Types of values that contain no range: most fields of a part.
_PLAIN: Final = frozenset({float, int, str, bool, type(None)})


def _walk(value: Any, visit: Callable[[_Place, Band], float | Band], place: _Place = _ROOT) -> Any:  # noqa: ANN401 - whatever a field holds
    """Return a value with its ranges replaced; the same object where it has none."""
    if isinstance(value, Band):
        return visit(place, value)
    if isinstance(value, Toleranced):
        nominal = visit(place, value.nominal) if isinstance(value.nominal, Band) else value.nominal
        return value if nominal is value.nominal else replace(value, nominal=nominal)
    if isinstance(value, Part):
        if isinstance(value, Material) or (place.owner is None and value.shareable):
            place = replace(place, owner=value, start=len(place.path))
        fields = {name: getattr(value, name) for name in type(value).model_fields}
        return _changed(
            value,
            fields
            | {
                name: _walk(each, visit, place.inside(name))
                for name, each in fields.items()
                if type(each) not in _PLAIN
            },
        )
    if isinstance(value, dict):
        each = {key: _walk(value[key], visit, place.inside(str(key))) for key in sorted(value)}
        return (
            {key: each[key] for key in value}
            if any(each[key] is not value[key] for key in value)
            else value
        )
    if isinstance(value, list | tuple):
        new = [
            _walk(inner, visit, place.inside(_step(inner, index)))
            for index, inner in enumerate(value)
        ]
        return (
            type(value)(new) if any(a is not b for a, b in zip(new, value, strict=True)) else value
        )
    return value


def _step(value: object, index: int) -> str:
    """Return the step of a member of a list: its name, as of a joint, or its number from 1."""
    name = getattr(value, "name", "")
    return (
        name if isinstance(value, BaseModel) and isinstance(name, str) and name else str(index + 1)
    )


def _changed(part: Part, values: dict[str, Any]) -> Part:
    if all(values[name] is getattr(part, name) for name in values):
        return part
    given = {
        name: value
        for name, value in values.items()
        if name in part.model_fields_set or value is not getattr(part, name)
    }
    out = type(part).model_validate(given)
    # neither stated values nor private ones change by a draw
    object.__setattr__(out, "__pydantic_fields_set__", set(part.model_fields_set))
    object.__setattr__(out, "__pydantic_private__", part.__pydantic_private__)
    return out


def _impossible(error: ValidationError, values: Mapping[str, float]) -> InputError:
    context = error.errors(include_url=False)[0].get("ctx", {})
    why = context.get("why", error.errors(include_url=False)[0]["msg"])
    drawn = ", ".join(f"{key} = {value:.6g}" for key, value in values.items())
    found = f"ranges that allow {why} (with {drawn}, in SI)"
    expected = (
        f"ranges of which all values are possible: {context.get('expected', 'narrower ones')}"
    )
    return InputError(
        [Problem("", ", ".join(values), found, expected, str(context.get("example", "")))]
    )
