"""Reducers of a user's own, row by row as the catalogue has them: under [[reducers]] in an arm
file, or in a file of rows beside it.

    catalogue = "my_reducers.toml"    # in the arm file: a file of rows, in the arm's folder or
                                      below it

    [[reducers]]                      # in the arm file, or in the file of rows
    models = ["X-10"]
    maker = "X"
    part = { rated_torque = "50 N m", stiffness = "20 N m/arcmin", backlash = "1 arcmin", hysteresis
    = "0.3 arcmin" }
    source = "measured on 5 pieces, 2024"

They go before the rows that ship with the package.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any, Final

from pydantic import ValidationError

from lostmotion.catalogue.gearbox_row import GearboxRow
from lostmotion.catalogue.printed_row import CheckedRow
from lostmotion.errors import InputError, Problem, shown
from lostmotion.io.limits import MOST_MISTAKES, nearest, refuse_all
from lostmotion.io.text import beside
from lostmotion.io.toml import read_toml
from lostmotion.io.toml_lines import names_lines
from lostmotion.io.validation_errors import problems

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.io.validation_errors import Path as KeyPath

ROWS: Final = "reducers"
FILE: Final = "catalogue"
FILE_EXAMPLE: Final = 'catalogue = "my_reducers.toml"'
ROW_EXAMPLE: Final = (
    '[[reducers]] with models = ["X-10"], maker = "X", part = { backlash = "1 arcmin" }, source = '
    '"measured, 2024"'
)
# What the top of an arm file takes for them.
OWN_EXAMPLES: Final = {ROWS: ROW_EXAMPLE, FILE: FILE_EXAMPLE}
_MOST_ROWS: Final = 500


@names_lines
def read_reducers(path: Path) -> tuple[GearboxRow, ...]:
    """Return the reducers of a file. A file of rows, or an arm file with some. Raises InputError
    with every mistake in the rows.
    """
    tree = read_toml(path)
    whole_arm = "joints" in tree
    rows, mistakes = take_reducers(str(path), tree) if whole_arm else _rows_of_file(path, tree)
    if mistakes:
        refuse_all(mistakes)
    return rows


def take_reducers(file: str, tree: dict[str, Any]) -> tuple[tuple[GearboxRow, ...], list[Problem]]:
    """Take what the tree of an arm file says of reducers of its own out of it: the rows, and the
    mistakes in them.
    """
    rows, mistakes = _rows(file, tree.pop(ROWS, []))
    if FILE in tree:
        more, others = _rows_beside(file, tree.pop(FILE))
        rows, mistakes = (*rows, *more), mistakes + others
        mistakes = mistakes or _clashes(file, rows)
    return rows, mistakes


def _rows_beside(file: str, stated: Any) -> tuple[tuple[GearboxRow, ...], list[Problem]]:  # noqa: ANN401 - whatever a file holds
    """Read the file of rows that an arm file names; nothing outside the arm's folder is read."""
    if not isinstance(stated, str) or not stated.isprintable() or not stated:
        return (), [
            Problem(
                file,
                FILE,
                shown(stated),
                "the name of a file of reducers in the arm's folder",
                FILE_EXAMPLE,
            )
        ]
    path = beside(file, stated)
    if path is None:
        return (), [
            Problem(
                file,
                FILE,
                f"{shown(stated)}, which leads out of the folder",
                "a file in the arm's folder or below it",
                FILE_EXAMPLE,
            )
        ]
    try:
        return _rows_of_file(path, read_toml(path))
    except InputError as error:
        return (), list(error.problems)


def _rows_of_file(path: Path, tree: dict[str, Any]) -> tuple[tuple[GearboxRow, ...], list[Problem]]:
    file = str(path)
    rows, mistakes = _rows(file, tree.pop(ROWS, None))
    for key, value in list(tree.items())[:MOST_MISTAKES]:
        mistakes.append(
            Problem(
                file,
                shown(key)[1:-1],
                f"an unknown key with {shown(value)}",
                f"rows under [[{ROWS}]]",
                ROW_EXAMPLE,
                nearest(key, [ROWS]),
            )
        )
    return rows, mistakes


def _rows(file: str, entries: Any) -> tuple[tuple[GearboxRow, ...], list[Problem]]:  # noqa: ANN401 - whatever a file holds
    """Check rows as those of the package are: every key, and the gearbox in each."""
    if not isinstance(entries, list):
        return (), [
            Problem(
                file,
                ROWS,
                "nothing" if entries is None else shown(entries),
                "a list of rows",
                ROW_EXAMPLE,
            )
        ]
    if len(entries) > _MOST_ROWS:
        return (), [
            Problem(file, ROWS, f"{len(entries)} rows", f"at most {_MOST_ROWS}", ROW_EXAMPLE)
        ]
    rows: list[GearboxRow] = []
    mistakes: list[Problem] = []
    for index, entry in enumerate(entries):
        key = f"{ROWS}[{index}]"
        if len(mistakes) > MOST_MISTAKES:
            break
        if not isinstance(entry, dict):
            mistakes.append(Problem(file, key, shown(entry), "a row", ROW_EXAMPLE))
            continue
        try:
            CheckedRow.model_validate(entry, context={"text": True})
            rows.append(GearboxRow.model_validate(entry, context={"text": True}))
        except ValidationError as error:
            mistakes += problems(error, CheckedRow, file, functools.partial(_key, key))
    return tuple(rows), mistakes or _clashes(file, rows)


def _key(key: str, path: KeyPath) -> str:
    return key + "".join(
        f"[{step}]" if isinstance(step, int) else f".{shown(step, 42)[1:-1]}" for step in path
    )


def _clashes(file: str, rows: tuple[GearboxRow, ...] | list[GearboxRow]) -> list[Problem]:
    """Note models that two rows describe for the same ratio."""
    met: dict[str, list[GearboxRow]] = {}
    out = []
    for row in rows:
        for model in row.models:
            before = met.setdefault(model, [])
            if any(_both_hold(row, other) for other in before):
                out.append(
                    Problem(
                        file,
                        ROWS,
                        f"{shown(model)} twice, with ratio {row.ratios}",
                        "one row for a model and a ratio",
                        f'models = ["{model}2"]',
                    )
                )
            before.append(row)
    return out[: MOST_MISTAKES + 1]


def _both_hold(one: GearboxRow, other: GearboxRow) -> bool:
    """Return whether some ratio belongs to both rows."""
    if one.ratio is not None:
        return other.applies_to(one.ratio)
    return True if other.ratio is None else one.applies_to(other.ratio)
