"""Reducers by their makers' names, with the ratio appended where it is stated: RV-40E, RV-40E-121,
CSG-25-100.
"""

from __future__ import annotations

import functools
import itertools
import re
from typing import TYPE_CHECKING, Final, NoReturn, TypeAlias

from lostmotion.catalogue import data_file
from lostmotion.catalogue.gearbox_row import GearboxRow
from lostmotion.errors import InputError, Problem, nearest, shown

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

Rows: TypeAlias = "Mapping[str, Sequence[GearboxRow]]"

_NONE: Final[Rows] = {}
# Number of a user's rows that are searched for the nearest name.
_NEAR_OWN: Final = 100
_MOST_MAKERS: Final = 4

_CODE: Final = re.compile(r"(?P<model>.+?)(?:-(?P<ratio>[0-9]{1,6}(?:\.[0-9]{1,6})?))?")


@functools.cache
def gearboxes() -> tuple[GearboxRow, ...]:
    """Return the known reducers in the order of the data file: by maker, series, size and ratio."""
    return tuple(
        GearboxRow.model_validate(row, context={"text": True})
        for row in data_file("gearboxes.toml")["reducers"]
    )


@functools.cache
def _packaged_by_model() -> dict[str, list[GearboxRow]]:
    return by_model(gearboxes())


def by_model(rows: Iterable[GearboxRow]) -> dict[str, list[GearboxRow]]:
    """Return the rows by name."""
    out: dict[str, list[GearboxRow]] = {}
    for row in rows:
        for model in row.models:
            out.setdefault(model, []).append(row)
    return out


def gearbox_models() -> tuple[str, ...]:
    """Return the names of the known reducers, without ratios."""
    return tuple(_packaged_by_model())


def find_gearbox(
    name: str, ratio: float | None = None, own: Rows = _NONE
) -> tuple[GearboxRow, float | None]:
    """Return the row of this name and the stated ratio: in the name ("CSG-25-100"), as an argument,
    or None.

    `own` are a user's rows by model, with priority over those of the package. Raises InputError
    with one problem for an unknown name (with the nearest known one), a name that needs a ratio and
    has none, two different ratios, and a ratio to which no row applies.
    """
    rows, model, behind = find_rows(name, own)
    if behind is not None and ratio is not None and behind != ratio:
        _refuse(
            f"{shown(name)} with the ratio {ratio:g}",
            "one ratio, in the name or beside it",
            f"{model}-{ratio:g}",
        )
    ratio = behind if ratio is None else ratio
    fitting = [row for row in rows if ratio is not None and row.applies_to(ratio)]
    choices = _or([row.ratios for row in rows])
    if ratio is None:
        if len(rows) > 1:
            _refuse(
                f"{shown(name)} without its ratio",
                f"its ratio appended, because the stiffness depends on it: {choices}",
                f"{model}-{_typical(rows)}",
            )
        fitting = list(rows)
    if not fitting:
        _refuse(
            f"{shown(model)} with the ratio {ratio:g}",
            f"a ratio with known figures of the maker: {choices}",
            f"{model}-{_typical(rows)}",
        )
    return fitting[0], ratio


def find_rows(name: str, own: Rows = _NONE) -> tuple[Sequence[GearboxRow], str, float | None]:
    """Return the rows of this name, the model, and the ratio appended to the name or None. Raises
    InputError for an unknown name.
    """
    model, behind = name, None
    rows = own.get(model) or _packaged_by_model().get(model)
    if not rows:
        match = _CODE.fullmatch(name)
        if match is not None and match["ratio"]:
            model, behind = match["model"], float(match["ratio"])
            rows = own.get(model) or _packaged_by_model().get(model)
    if not rows:
        names = [*itertools.islice(own, _NEAR_OWN), *gearbox_models()]
        near = nearest(name, [*names, *(f"{each}-{behind:g}" for each in names if behind)])
        first = {
            row.maker: row.models[0]
            for row in reversed(
                [*(rows[0] for rows in itertools.islice(own.values(), _NEAR_OWN)), *gearboxes()]
            )
        }
        makers = ", ".join(
            f"{each} … by {maker}" for maker, each in list(reversed(first.items()))[:_MOST_MAKERS]
        )
        _refuse(
            shown(name),
            f"a reducer of the catalogue ({makers}), with or without its ratio",
            near or "RV-40E-121",
            near,
        )
    return rows, model, behind


def _typical(rows: Sequence[GearboxRow]) -> str:
    return "100" if any(row.applies_to(100) for row in rows) else f"{rows[0].typical_ratio:g}"


def _refuse(found: str, expected: str, example: str, near: str = "") -> NoReturn:
    raise InputError([Problem("the catalogue", "gearboxes", found, expected, example, near)])


def _or(names: list[str]) -> str:
    return " or ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
