"""The catalogue as figures: tables of what was found, or one entry whole."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from lostmotion.analyses.catalog.entry import (
    TABLES,
    Kind,
    label_of,
    plain_row,
    searched_figures,
    whole_entry,
)
from lostmotion.band import limits_of
from lostmotion.catalogue import materials
from lostmotion.catalogue.clearances import tables
from lostmotion.catalogue.gearbox_row import source_in_words
from lostmotion.catalogue.gearboxes import (
    gearboxes,
)
from lostmotion.catalogue.presets import presets
from lostmotion.catalogue.search import Criteria, SearchResult, search
from lostmotion.errors import refuse_argument
from lostmotion.reporting.sheet import Cell, Sheet, table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.catalogue.gearbox_row import GearboxRow
    from lostmotion.parts.link import Material
    from lostmotion.reporting.sheet import Section


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
        return whole_entry(name, wanted.ratio, kind, own)
    with_gearboxes = kind in (None, "gearbox")
    found = search([*own, *gearboxes()], wanted) if with_gearboxes else SearchResult((), {})
    others: list[Section] = []
    if kind == "bearing" or (kind is None and wanted.empty):
        others += _table_sections()
    if kind == "material" or (kind is None and wanted.empty):
        others.append(_material_section())
    if kind == "preset" or (kind is None and wanted.empty):
        others.append(_preset_section())
    unstated = {
        figure: [label_of(row) for row in rows] for figure, rows in found.not_stated.items()
    }
    facts: dict[str, Any] = {"not_stated": unstated}
    if with_gearboxes:
        facts["gearboxes"] = [plain_row(row) for row in found.rows]
    for section in others:
        facts[section.key] = [*facts.get(section.key, []), *(row.label for row in section.rows)]
    return Sheet(
        name="Catalogue",
        subject="reducers, bearings, materials, presets",
        sections=(*_gearbox_sections(found.rows), *others),
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
    silent = [label_of(row, 1) for row in rows if row.figures.part.mass is None]
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
    return ", ".join(label_of(row, 1) for row in rows[:3]) + (" …" if len(rows) > 3 else "")  # noqa: PLR2004 - enough to know which


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
        lines = (
            (
                label_of(row),
                *searched_figures(row),
                _backlash(row)
                or _limits("also only a limit", [x for x in row.upper_limits if x not in shared]),
            )
            for row in group
        )
        note = f"Source: {source_in_words(source)}." + _limits(" Only upper limits", shared, ".")
        # several series of one maker, each from a source of its own
        title = ", ".join([maker, *source.split(", ")[1:2]])
        columns = ["rated torque", "stiffness, softest zone", "lost motion", "mass"]
        out.append(table("gearboxes", title, columns, lines, note))
    return out


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
        table(
            "bearings",
            f"Bearings: {what}",
            (),
            (
                (
                    name,
                    (
                        f"over {_mm(each.rows[0].over)} to {_mm(each.rows[-1].to)} mm; "
                        f"{', '.join(each.rows[0].limits)}; {source_in_words(each.source)}"
                    ),
                )
                for name, each in tables(file).items()
            ),
        )
        for file, what in TABLES.items()
    ]


def _mm(size: float) -> str:
    return f"{size * 1e3:g}"


def _material_section() -> Section:
    return table(
        "materials",
        "Materials",
        ["Young", "shear", "Poisson", "density", "scatter ±", "expansion"],
        (
            (name, *_of_material(material), source_in_words(material.source))
            for name, material in materials().items()
        ),
    )


def _preset_section() -> Section:
    return table(
        "presets",
        "Presets",
        (),
        (
            (row.name, f"{row.type} {row.part}".strip() + f"; {source_in_words(row.source)}")
            for of_part in presets().values()
            for row in of_part.values()
        ),
        'typical values of a class of parts, all of them assumed: preset = "NAME" in the '
        "table of that part",
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
