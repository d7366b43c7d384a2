"""One entry of the catalogue as a whole."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Any, Final, Literal

from lostmotion.catalogue import data_file, materials
from lostmotion.catalogue.clearances import tables
from lostmotion.catalogue.gearbox_row import mark_of, source_in_words
from lostmotion.catalogue.gearboxes import (
    by_model,
    find_gearbox,
    find_rows,
    gearbox_models,
)
from lostmotion.catalogue.presets import PARTS, PresetRow, presets
from lostmotion.catalogue.search import searchable_figures
from lostmotion.errors import InputError, Problem, nearest, shown
from lostmotion.reporting.sheet import Cell, Sheet, table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.catalogue.clearances import Range
    from lostmotion.catalogue.gearbox_row import GearboxRow
    from lostmotion.reporting.sheet import Section

Kind = Literal["gearbox", "bearing", "material", "preset"]
_UNITS: Final = {
    "rated torque": "N m",
    "stiffness": "N m/arcmin",
    "lost motion": "arcmin",
    "mass": "kg",
}
# Names of an unknown word that a message lists.
_MOST_NAMES: Final = 6
TABLES: Final[dict[Literal["clearances", "fits"], str]] = {
    "clearances": "radial clearance by bore",
    "fits": "deviation by diameter",
}


def label_of(row: GearboxRow, names: int | None = None) -> str:
    """Return the models of a row, or the first few of them, with its ratio."""
    return ", ".join(row.models[:names]) + (
        "" if row.typical_ratio is None else f" ratio {row.ratios}"
    )


def searched_figures(row: GearboxRow) -> tuple[Cell, ...]:
    """Return the figures that are searched for."""
    return tuple(
        Cell(value, "1") if math.isnan(value) else Cell(value, _UNITS[name], stated=True)
        for name, value in searchable_figures(row).items()
    )


def whole_entry(
    name: str, ratio: float | None, kind: Kind | None, own: Sequence[GearboxRow]
) -> Sheet:
    """Return one entry with all that is known of it."""
    if kind in (None, "material") and name in materials():
        stated = data_file("materials.toml")[name]
        lines = ((key, source_in_words(str(value))) for key, value in stated.items())
        section = table("materials", "Material", (), lines)
        return _sheet(name, [section], [{"name": name, **stated}])
    of_name = [
        row for of_part in presets().values() for row in of_part.values() if row.name == name
    ]
    if kind in (None, "preset") and of_name:
        return _sheet(
            name,
            [table("presets", f"Preset of a {row.part}", (), _lines_of(row)) for row in of_name],
            [
                {"name": name, "part": row.part, **row.values, "source": row.source}
                for row in of_name
            ],
        )
    for file, what in TABLES.items():
        if kind in (None, "bearing") and name in tables(file):
            ranges = tables(file)[name]
            section = table(
                "bearings",
                f"{what.capitalize()}, µm from … to",
                (),
                ((str(row), _bands(row)) for row in ranges.rows),
                f"Source: {source_in_words(ranges.source)}.",
            )
            known_rows = [{"over": row.over, "to": row.to, **row.limits} for row in ranges.rows]
            unstated = {"source": ranges.source, "rows": known_rows}
            entry = {"name": name, **data_file(f"{file}.toml").get(name, unstated)}
            return _sheet(name, [section], [entry])
    if kind in (None, "gearbox"):
        rows = _named(name, ratio, own, alone=kind is not None)
        if rows:
            sections = [table("gearboxes", label_of(row), (), _whole(row, name)) for row in rows]
            return _sheet(name, sections, [plain_row(row) for row in rows])
    known = [*materials()] if kind in (None, "material") else []
    known += (
        [entry for file in TABLES for entry in tables(file)] if kind in (None, "bearing") else []
    )
    known += (
        [each for of_part in presets().values() for each in of_part]
        if kind in (None, "preset")
        else []
    )
    models = (
        [*itertools.chain.from_iterable(row.models for row in own), *gearbox_models()]
        if kind is None
        else []
    )
    near = nearest(name, [*known, *models])
    word = name.casefold()
    having = [each for each in dict.fromkeys([*known, *models]) if word and word in each.casefold()]
    of_kind = "" if kind is None else f" --kind {kind}"
    expected = (
        f"{', '.join(having[:_MOST_NAMES])}{', …' if len(having) > _MOST_NAMES else ''}"
        if having
        else f"a name of the catalogue: `lostmotion catalog{of_kind}` lists them, and options "
        "search by figures"
    )
    raise InputError(
        [
            Problem(
                "the catalogue",
                "NAME",
                shown(name),
                expected,
                f'lostmotion catalog "{near or [*having, *known][0]}"',
                near,
            )
        ]
    )


def _lines_of(row: PresetRow) -> list[tuple[str, str]]:
    """Return every value of a preset, as it would stand in a file, and its source."""
    lines = []
    for key, value in row.values.items():
        inner = value.items() if isinstance(value, dict) and key in PARTS else [("", value)]
        lines += [(f"{key}.{step}" if step else key, _text(each)) for step, each in inner]
    return [*lines, ("source", source_in_words(row.source))]


def _text(value: Any) -> str:  # noqa: ANN401 - a value of a TOML
    if isinstance(value, dict):
        return ", ".join(f"{key} {_text(each)}" for key, each in value.items())
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)


def _named(
    name: str, ratio: float | None, own: Sequence[GearboxRow], *, alone: bool
) -> Sequence[GearboxRow]:
    """Find the rows of a reducer's name; none where it is unknown and may be the name of something
    else.
    """
    try:
        rows, _, behind = find_rows(name, by_model(own))
    except InputError:
        if alone:
            raise
        return ()
    return (
        rows if ratio is None and behind is None else [find_gearbox(name, ratio, by_model(own))[0]]
    )


def _sheet(name: str, sections: Sequence[Section], entries: Sequence[dict[str, Any]]) -> Sheet:
    facts = {"entries": list(entries)}
    return Sheet(name=name, subject="catalogue", sections=tuple(sections), facts=facts)


def _bands(row: Range) -> str:
    return ";  ".join(
        f"{group} {low * 1e6:g} … {high * 1e6:g}" for group, (low, high) in row.limits.items()
    )


def _whole(row: GearboxRow, name: str) -> list[tuple[str, str]]:
    """Return everything about a row, with the makers' own words and what they do not specify."""
    facts, use = row.figures, name
    if name in row.models:
        use = f"{name}-{row.typical_ratio or 100:g}"
    of_ratio = ", ".join(
        f"{ratio}: {value * 1e4:.3g}" for ratio, value in row.inertia_by_ratio.items()
    )
    torques = ", ".join(
        f"{ratio}: {' / '.join(f'{each:.4g}' for each in torques)}"
        for ratio, torques in row.torques_by_ratio.items()
    )
    typical = {key: value for key, value in row.typical.items() if key != "source"}
    lines = [
        ("maker", row.maker),
        ("ratio", row.ratios),
        *(
            (
                key,
                (", ".join(map(str, value)) if isinstance(value, list) else str(value))
                + (" (the maker's upper limit)" if key in row.upper_limits else ""),
            )
            for key, value in row.part.items()
        ),
        *(
            (key, str(Cell(value, unit, stated=True)) if value else "")
            for key, value, unit in (
                ("lost_motion as printed", facts.lost_motion, "arcmin"),
                ("moment_rigidity", facts.moment_rigidity, "N m/arcmin"),
                ("acceleration_torque", facts.acceleration_torque, "N m"),
                ("emergency_torque", facts.emergency_torque, "N m"),
            )
        ),
        *(
            (
                f"typical {key}",
                (
                    f'{value}, where a file asks for values = "typical" '
                    f"({source_in_words(str(row.typical['source']))})"
                ),
            )
            for key, value in typical.items()
        ),
        ("inertia by ratio", of_ratio and f"{of_ratio} kg cm^2"),
        ("rated, repeated peak and momentary peak torque by ratio", torques and f"{torques} N m"),
        ("torques from", row.torque_source and source_in_words(row.torque_source)),
        ("mass from", row.mass_source and source_in_words(row.mass_source)),
        ("inertia from", row.inertia_source and source_in_words(row.inertia_source)),
        ("mass", "not stated: counted as zero" if facts.part.mass is None else ""),
        ("printed", row.printed),
        ("not specified", ", ".join(row.unstated)),
        ("source", source_in_words(row.source)),
        ("in an arm file", f'gearbox = "{use}"'),
    ]
    return [(key, text) for key, text in lines if text]


def plain_row(row: GearboxRow) -> dict[str, Any]:
    """Return a row as data: what it says as text with units, and the figures that are searched
    for.
    """
    stated = {
        name: figure
        for name, figure in zip(_UNITS, searched_figures(row), strict=True)
        if not math.isnan(figure.value)
    }
    return {
        "models": row.models,
        "maker": row.maker,
        "ratio": row.ratio,
        "ratio_one_of": list(row.ratio_one_of),
        "ratio_above": row.ratio_above,
        "part": row.part,
        "upper_limits": list(row.upper_limits),
        "printed": row.printed,
        "figures": {
            name: {"value": figure.value, "unit": figure.unit} for name, figure in stated.items()
        },
        "source": row.source,
        "confidence": mark_of(row.source),
    }
