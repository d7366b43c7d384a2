"""The catalogue as figures: tables of what was found, or one entry whole."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, Literal

from lostmotion.band import limits_of
from lostmotion.catalogue import data_file, materials
from lostmotion.catalogue.clearances import tables
from lostmotion.catalogue.gearbox_row import mark_of, source_in_words
from lostmotion.catalogue.gearboxes import (
    by_model,
    find_gearbox,
    find_rows,
    gearbox_models,
    gearboxes,
)
from lostmotion.catalogue.presets import PARTS, PresetRow, presets
from lostmotion.catalogue.search import Criteria, SearchResult, search, searchable_figures
from lostmotion.errors import InputError, Problem, nearest, refuse_argument, shown
from lostmotion.reporting.sheet import Cell, Row, Section, Sheet

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.catalogue.clearances import Range
    from lostmotion.catalogue.gearbox_row import GearboxRow
    from lostmotion.parts.link import Material

Kind = Literal["gearbox", "bearing", "material", "preset"]

_UNITS: Final = {
    "rated torque": "N m",
    "stiffness": "N m/arcmin",
    "lost motion": "arcmin",
    "mass": "kg",
}
_TABLES: Final[dict[Literal["clearances", "fits"], str]] = {
    "clearances": "radial clearance by bore",
    "fits": "deviation by diameter",
}


def catalogue_sheet(
    wanted: Criteria,
    kind: Kind | None = None,
    name: str | None = None,
    own: Sequence[GearboxRow] = (),
) -> Sheet:
    """Return the rows of the catalogue that match, or the one of this name. `own` are a user's
    rows, which stand before those of the package.

    Raises InputError for a name that is not there, a maker without rows, and for figures of
    gearboxes asked of another kind.
    """
    if kind not in (None, "gearbox") and not wanted.empty:
        raise refuse_argument(
            "kind",
            kind,
            "gearbox: torque, lost motion, stiffness, ratio and maker are figures of gearboxes",
            kind="gearbox",
        )
    if name is not None and not replace(wanted, ratio=None).empty:
        raise refuse_argument(
            "name", name, "a name, or figures to search by, not both", min_torque="300 N m"
        )
    if name is not None:
        return _one(name, wanted.ratio, kind, own)
    with_gearboxes = kind in (None, "gearbox")
    found = search([*own, *gearboxes()], wanted) if with_gearboxes else SearchResult((), {})
    others: list[Section] = []
    if kind == "bearing" or (kind is None and wanted.empty):
        others += _table_sections()
    if kind == "material" or (kind is None and wanted.empty):
        others.append(_material_section())
    if kind == "preset" or (kind is None and wanted.empty):
        others.append(_preset_section())
    unstated = {figure: [_label(row) for row in rows] for figure, rows in found.not_stated.items()}
    facts: dict[str, Any] = {"not_stated": unstated}
    if with_gearboxes:
        facts["gearboxes"] = [_plain(row) for row in found.rows]
    for section in others:
        facts[section.key] = [*facts.get(section.key, []), *(row.label for row in section.rows)]
    return Sheet(
        name="Catalogue",
        subject="reducers, bearings, materials, presets",
        verdict="",
        cards=(),
        sections=(*_gearbox_sections(found.rows), *others),
        source="",
        counts=_count(found.rows) if with_gearboxes else "",
        notes=(
            *(
                f"{len(rows)} more {_rows(len(rows))} not state {figure}: {_names(rows)}"
                for figure, rows in found.not_stated.items()
            ),
            *_unweighed(found.rows),
        ),
        facts=facts,
    )


def _unweighed(rows: Sequence[GearboxRow]) -> list[str]:
    """Return the note on rows without a mass, and on what the masses of the others include."""
    silent = [_label(row, 1) for row in rows if row.figures.part.mass is None]
    notes = [f"mass of {', '.join(silent)} not stated: counted as zero"] if silent else []
    of_source: dict[str, list[GearboxRow]] = {}
    for row in rows:
        if row.mass_source:
            of_source.setdefault(row.mass_source, []).append(row)
    return notes + [
        f"mass of {_names(each)}: {source_in_words(source)}" for source, each in of_source.items()
    ]


def _count(rows: Sequence[GearboxRow]) -> str:
    return (
        f"{len(rows)} {'reducer' if len(rows) == 1 else 'reducers'}"
        if rows
        else "no reducer is known to be like that"
    )


def _rows(count: int) -> str:
    return "row does" if count == 1 else "rows do"


def _names(rows: Sequence[GearboxRow]) -> str:
    return ", ".join(_label(row, 1) for row in rows[:3]) + (" …" if len(rows) > 3 else "")  # noqa: PLR2004 - enough to know which


def _label(row: GearboxRow, names: int | None = None) -> str:
    return ", ".join(row.models[:names]) + (
        "" if row.typical_ratio is None else f" ratio {row.ratios}"
    )


def _gearbox_sections(rows: Sequence[GearboxRow]) -> list[Section]:
    """Lay rows out by their source, which is printed once for all of them."""
    out = []
    for (maker, source), each in itertools.groupby(rows, lambda row: (row.maker, row.source)):
        group = list(each)
        shared = [
            limit
            for limit in group[0].upper_limits
            if all(limit in row.upper_limits for row in group)
        ]
        lines = tuple(
            Row(
                _label(row),
                _figures(row),
                _backlash(row)
                or _limits("also only a limit", [x for x in row.upper_limits if x not in shared]),
            )
            for row in group
        )
        note = f"Source: {source_in_words(source)}." + _limits(" Only upper limits", shared, ".")
        # several series of one maker, each from a source of its own
        title = ", ".join([maker, *source.split(", ")[1:2]])
        out.append(
            Section(
                "gearboxes",
                title,
                ("rated torque", "stiffness, softest zone", "lost motion", "mass"),
                lines,
                note,
            )
        )
    return out


def _figures(row: GearboxRow) -> tuple[Cell, ...]:
    return tuple(
        Cell(value, "1") if math.isnan(value) else Cell(value, _UNITS[name], stated=True)
        for name, value in searchable_figures(row).items()
    )


def _backlash(row: GearboxRow) -> str:
    """Return the backlash of a row that states it and no lost motion."""
    figures = row.figures
    if (
        figures.part.backlash is None
        or figures.part.lost_motion is not None
        or figures.lost_motion is not None
    ):
        return ""
    return (
        "backlash "
        f"{'up to ' if 'backlash' in row.upper_limits else ''}{Cell(figures.part.backlash.nominal, 'arcmin', stated=True)}"  # noqa: E501
    )


def _limits(what: str, names: Sequence[str], end: str = "") -> str:
    return f"{what}: {', '.join(name.replace('_', ' ') for name in names)}{end}" if names else ""


def _table_sections() -> list[Section]:
    return [
        Section(
            "bearings",
            f"Bearings: {what}",
            (),
            tuple(
                Row(
                    name,
                    (),
                    (
                        f"over {_mm(table.rows[0].over)} to {_mm(table.rows[-1].to)} mm; "
                        f"{', '.join(table.rows[0].limits)}; "
                    )
                    + source_in_words(table.source),
                )
                for name, table in tables(file).items()
            ),
        )
        for file, what in _TABLES.items()
    ]


def _mm(size: float) -> str:
    return f"{size * 1e3:g}"


def _material_section() -> Section:
    lines = tuple(
        Row(name, _of_material(material), source_in_words(material.source))
        for name, material in materials().items()
    )
    return Section(
        "materials",
        "Materials",
        ("Young", "shear", "Poisson", "density", "scatter ±", "expansion"),
        lines,
    )


def _preset_section() -> Section:
    rows = (row for of_part in presets().values() for row in of_part.values())
    lines = tuple(
        Row(row.name, (), f"{row.type} {row.part}".strip() + f"; {source_in_words(row.source)}")
        for row in rows
    )
    return Section(
        "presets",
        "Presets",
        (),
        lines,
        (
            'typical values of a class of parts, all of them assumed: preset = "NAME" in the '
            "table of that part"
        ),
    )


def _of_material(material: Material) -> tuple[Cell, ...]:
    return (
        _of_range(material.young, "GPa"),
        Cell(material.shear, "GPa", stated=True),
        _of_range(material.poisson, "1"),
        _of_range(math.nan if material.density is None else material.density, "kg/m³"),
        Cell(material.scatter, "%", stated=True),
        Cell(
            math.nan if material.expansion is None else material.expansion,
            "µm/m/K",
            stated=True,
        ),
    )


def _of_range(value: float, unit: str) -> Cell:
    """Return a value as stated, or as the range in which it lies."""
    low, high = (str(Cell(end, unit, stated=True)) for end in limits_of(value))
    return Cell(
        value,
        unit,
        stated=True,
        words="" if low == high else f"{low.removesuffix(unit).strip()} .. {high}",
    )


def _one(name: str, ratio: float | None, kind: Kind | None, own: Sequence[GearboxRow]) -> Sheet:
    """Return one entry with all that is known of it."""
    if kind in (None, "material") and name in materials():
        lines = tuple(
            Row(key, (), source_in_words(str(value)))
            for key, value in data_file("materials.toml")[name].items()
        )
        return _sheet(
            name,
            [Section("materials", "Material", (), lines)],
            [{"name": name, **data_file("materials.toml")[name]}],
        )
    rows_of_presets = [
        row for of_part in presets().values() for row in of_part.values() if row.name == name
    ]
    if kind in (None, "preset") and rows_of_presets:
        sections = [
            Section("presets", f"Preset of a {row.part}", (), tuple(_lines_of(row)))
            for row in rows_of_presets
        ]
        return _sheet(
            name,
            sections,
            [
                {"name": name, "part": row.part, **row.values, "source": row.source}
                for row in rows_of_presets
            ],
        )
    for file, what in _TABLES.items():
        if kind in (None, "bearing") and name in tables(file):
            table = tables(file)[name]
            lines = tuple(Row(str(row), (), _bands(row)) for row in table.rows)
            section = Section(
                "bearings",
                f"{what.capitalize()}, µm from … to",
                (),
                lines,
                f"Source: {source_in_words(table.source)}.",
            )
            known_rows = [{"over": row.over, "to": row.to, **row.limits} for row in table.rows]
            return _sheet(
                name,
                [section],
                [
                    {
                        "name": name,
                        **data_file(f"{file}.toml").get(
                            name, {"source": table.source, "rows": known_rows}
                        ),
                    }
                ],
            )
    if kind in (None, "gearbox"):
        rows = _named(name, ratio, own, alone=kind is not None)
        if rows:
            sections = [
                Section("gearboxes", _label(row), (), tuple(_whole(row, name))) for row in rows
            ]
            return _sheet(name, sections, [_plain(row) for row in rows])
    known = [*materials()] if kind in (None, "material") else []
    known += (
        [entry for file in _TABLES for entry in tables(file)] if kind in (None, "bearing") else []
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
    expected = "a name of the catalogue: " + ", ".join(known) + (", or a reducer" if models else "")
    raise InputError(
        [
            Problem(
                "the catalogue",
                "NAME",
                shown(name),
                expected,
                f'lostmotion catalog "{near or known[0]}"',
                near,
            )
        ]
    )


def _lines_of(row: PresetRow) -> list[Row]:
    """Return every value of a preset, as it would stand in a file, and its source."""
    lines = []
    for key, value in row.values.items():
        inner = value.items() if isinstance(value, dict) and key in PARTS else [("", value)]
        lines += [Row(f"{key}.{step}" if step else key, (), _text(each)) for step, each in inner]
    return [*lines, Row("source", (), source_in_words(row.source))]


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
    return Sheet(
        name=name,
        subject="catalogue",
        verdict="",
        cards=(),
        sections=tuple(sections),
        source="",
        facts={"entries": list(entries)},
    )


def _bands(row: Range) -> str:
    return ";  ".join(
        f"{group} {low * 1e6:g} … {high * 1e6:g}" for group, (low, high) in row.limits.items()
    )


def _whole(row: GearboxRow, name: str) -> list[Row]:
    """Return everything about a row, with the makers' own words and what they do not specify."""
    lines = [("maker", row.maker), ("ratio", row.ratios)]
    for key, value in row.part.items():
        text = ", ".join(str(each) for each in value) if isinstance(value, list) else str(value)
        lines.append(
            (key, text + (" (the maker's upper limit)" if key in row.upper_limits else ""))
        )
    facts = row.figures
    for key, value, unit in (
        ("lost_motion as printed", facts.lost_motion, "arcmin"),
        ("moment_rigidity", facts.moment_rigidity, "N m/arcmin"),
        ("acceleration_torque", facts.acceleration_torque, "N m"),
        ("emergency_torque", facts.emergency_torque, "N m"),
    ):
        if value:
            lines.append((key, str(Cell(value, unit, stated=True))))
    for key, value in row.typical.items():
        if key != "source":
            lines.append(
                (
                    f"typical {key}",
                    (
                        f'{value}, where a file asks for values = "typical" '
                        f"({source_in_words(str(row.typical['source']))})"
                    ),
                )
            )
    if row.inertia_by_ratio:
        lines.append(
            (
                "inertia by ratio",
                ", ".join(
                    f"{ratio}: {value * 1e4:.3g}" for ratio, value in row.inertia_by_ratio.items()
                )
                + " kg cm^2",
            )
        )
    if row.torques_by_ratio:
        by_ratio = ", ".join(
            f"{ratio}: {' / '.join(f'{each:.4g}' for each in torques)}"
            for ratio, torques in row.torques_by_ratio.items()
        )
        lines.append(("rated, repeated peak and momentary peak torque by ratio", f"{by_ratio} N m"))
    sources = {
        "torques from": row.torque_source,
        "mass from": row.mass_source,
        "inertia from": row.inertia_source,
    }
    lines += [(name, source_in_words(text)) for name, text in sources.items() if text]
    lines += [("mass", "not stated: counted as zero")] if facts.part.mass is None else []
    lines += [("printed", row.printed)] if row.printed else []
    lines += [("not specified", ", ".join(row.unstated))] if row.unstated else []
    use = f"{name}-{row.typical_ratio or 100:g}" if name in row.models else name
    lines += [("source", source_in_words(row.source)), ("in an arm file", f'gearbox = "{use}"')]
    return [Row(key, (), text) for key, text in lines]


def _plain(row: GearboxRow) -> dict[str, Any]:
    """Return a row as data: what it says as text with units, and the figures that are searched
    for.
    """
    stated = {
        name: figure
        for name, figure in zip(_UNITS, _figures(row), strict=True)
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
