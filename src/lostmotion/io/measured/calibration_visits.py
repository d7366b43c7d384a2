"""CSV files of visits by which an arm is calibrated: joint values, and what an instrument read.

    A [deg], B [deg], ..., x [mm], y [mm], z [mm], qw, qx, qy, qz

One row per visit. Joints are named as in the arm's file; joint_1, joint_2, ... are read in order.
x, y and z are the attained tool point; qw to qz, or rx, ry and rz (rotations about the fixed axes,
in that order), its orientation. dx, dy and dz are differences to the commanded point, whose sign is
found by the fit. `A approach` is the sign of the last motion of joint A.

In their place one number: distance [mm] with `to`, the name of its fixed end; dial [mm] with
`along`, or angle [deg] with `about`, an axis x, y or z of the base; `plane`, the name of a plane
that is touched; `sphere` and radius [mm] the same. Or the four corners of a `tag` on the tool, a
row each: pixels `u` and `v` of a camera that stands still, and the number of the `corner`, 0 to 3.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.calibration.instruments import MeasuredVisits, Readings
from lostmotion.errors import Problem
from lostmotion.io.limits import listed, refuse_all
from lostmotion.io.measured.calibration_checks import (
    FEWEST,
    HEADINGS,
    PARTIAL,
    PIXELS,
    POINT,
    differing,
    mistakes_in_targets,
    not_unit,
    other_units,
    outside_limits,
    stated_above,
    whole_tags,
)
from lostmotion.io.measured.calibration_header import read_header
from lostmotion.io.measured.orientations import QUATERNION, TURNS, rotations
from lostmotion.io.measured.table import (
    MEGABYTES,
    MOST_MISTAKES,
    Layout,
    find_columns,
    read_table,
    role_values,
)
from lostmotion.io.text import numbers, read_text
from lostmotion.mechanism.state import tool_points

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from numpy.typing import NDArray

    from lostmotion.calibration.instruments import Camera
    from lostmotion.calibration.terms import Deviations
    from lostmotion.io.measured.instrument import Instrument
    from lostmotion.io.measured.table import TextTable
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

DIFFERENCE: Final = ("dx", "dy", "dz")
# Joint values beyond 1.05 turns are degrees, coordinates beyond 20 are millimetres.
_LARGEST_ANGLE: Final = 6.6
_LARGEST_LENGTH: Final = 20.0
_UNIT_LENGTH: Final = 0.02
_SAME_JOINTS: Final = 1e-9
# Columns that each instrument means; all others of `_MEASURED` are then ignored.
_POINTS: Final = {*POINT, *DIFFERENCE}
_COLUMNS: Final[dict[str, set[str]]] = {
    "tracker": _POINTS,
    "points": _POINTS,
    "poses": {*POINT, *TURNS, *QUATERNION},
    "distance": {"distance", "to"},
    "plane": {"plane"},
    "sphere": {"sphere", "radius"},
    "dial": {"dial", "along"},
    "inclinometer": {"angle", "about"},
    "tags": {*PIXELS, "tag"},
}
_MEASURED: Final = set().union(*_COLUMNS.values())
_ALIASES: Final = {f"{axis}_dif": f"d{axis}" for axis in "xyz"}


@dataclass(frozen=True, eq=False)
class CalibrationVisits(MeasuredVisits):
    """Visits of one robot, as read from files.

    file        first of the files
    lines       line of each visit in its file
    duplicates  number of rows that repeat another and were dropped
    remarks     what was assumed
    digest      hash of the files
    noise       standard deviation of a coordinate, m, as stated above the rows
    sizes       deviations of errors that the arm's file does not state, as stated above the rows
    """

    file: str = ""
    lines: tuple[int, ...] = ()
    duplicates: int = 0
    remarks: tuple[str, ...] = ()
    digest: str = ""
    noise: float | None = None
    sizes: Deviations | None = None


def read_calibration_visits(
    path: Path | Sequence[Path],
    arm: Arm,
    mapping: Sequence[str] = (),
    instrument: Instrument | None = None,
) -> CalibrationVisits:
    """Return the visits of these files to poses of an arm, without rows that repeat another one.

    instrument  which columns of a file are meant; None: as stated above its rows, or the only ones

    Raises InputError with every mistake, its file and line.
    """
    files = [path] if isinstance(path, str | Path) else list(path)
    found = [_read(Path(each), arm, mapping, instrument) for each in files]
    kinds = [
        (each.point is None, each.rotation is None, each.readings and each.readings.kind)
        for each in found
    ]
    if len(set(kinds)) > 1:
        expected = "files that measure the same: points, differences, or poses"
        refuse_all(
            [Problem(str(files[kinds.index(kinds[-1])]), "line 1", "another kind", expected)]
        )
    mistakes = differing(
        [(each.file, stated_above(each.noise, each.sizes, each.readings)) for each in found]
    )
    if mistakes:
        refuse_all(mistakes)
    digest = hashlib.blake2b(digest_size=16)
    for each in files:
        digest.update(Path(each).read_bytes())
    joined = replace(
        found[0],
        q=np.concatenate([each.q for each in found]),
        point=_joined([each.point for each in found]),
        difference=_joined([each.difference for each in found]),
        rotation=_joined([each.rotation for each in found]),
        approach=np.concatenate([np.asarray(each.approach) for each in found]),
        lines=tuple(line for each in found for line in each.lines),
        readings=_joined_readings([each.readings for each in found if each.readings]),
        remarks=tuple(dict.fromkeys(text for each in found for text in each.remarks)),
        digest=digest.hexdigest(),
    )
    kept = _without_duplicates(joined)
    if len(kept) < FEWEST:
        expected = f"at least {FEWEST} different rows; 10 to 50 calibrate an arm"
        refuse_all([Problem(str(files[0]), "", f"{len(kept)} different rows", expected)])
    return kept


def _joined(parts: list[Floats | None]) -> Floats | None:
    present = [part for part in parts if part is not None]
    return np.concatenate(present) if present else None


def _joined_readings(parts: Sequence[Readings]) -> Readings | None:
    if not parts:
        return None
    value = np.concatenate([part.value for part in parts])
    targets = sum((part.target for part in parts), ())
    return parts[0]._replace(value=value, target=targets)


def _without_duplicates(visits: CalibrationVisits) -> CalibrationVisits:
    """Return visits without those that repeat joints and measurement of another one: a point, a
    difference, or the corners of a tag.
    """
    measured = visits.point if visits.point is not None else visits.difference
    names = ("",) * len(visits)
    if visits.readings is not None and visits.readings.kind == "tags":
        measured, names = visits.readings.value, visits.readings.target
    if measured is None:
        return visits
    first: dict[tuple[str, bytes], int] = {}
    for k, (name, q, read) in enumerate(zip(names, visits.q, measured, strict=True)):
        first.setdefault((name, np.round(q / _SAME_JOINTS).tobytes() + read.tobytes()), k)
    kept = np.array(list(first.values()))
    return replace(
        visits.rows(kept),
        lines=tuple(visits.lines[k] for k in kept),
        duplicates=len(visits) - len(kept),
    )


def _layout(
    arm: Arm, names: Collection[str], instrument: str | None = None
) -> tuple[Layout, dict[str, str]]:
    """Return what a file with these headings may hold, and the role of each joint."""
    own = [joint.name for joint in arm.driven]
    numbered = [f"joint_{k + 1}" for k in range(len(own))]
    of = dict(zip(own, numbered if not set(own) & set(names) else own, strict=True))
    kinds = {
        role: ("m", "mm") if joint.type == "prismatic" else ("rad", "deg")
        for joint, role in zip(arm.driven, of.values(), strict=True)
    }
    lengths = dict.fromkeys((*POINT, *DIFFERENCE), ("m", "mm"))
    example = ", ".join(f"{role} [{unit}]" for role, (_, unit) in kinds.items())
    units = {
        **kinds,
        **lengths,
        **dict.fromkeys((*TURNS, "angle"), ("rad", "deg")),
        **dict.fromkeys(("distance", "dial", "radius"), ("m", "mm")),
    }
    left_out = set() if instrument is None else _MEASURED - _COLUMNS[instrument]
    words = ("to", "along", "about", "plane", "sphere", "tag")
    counts = (*QUATERNION, *PIXELS, *(f"{name} approach" for name in own))
    layout = Layout(
        words=tuple(role for role in words if role not in left_out),
        units={role: unit for role, unit in units.items() if role not in left_out},
        header=f"{example}, x [mm], y [mm], z [mm]",
        example="examples/measured/ur5-grid.csv",
        mapping="dx = x_dif [mm]",
        counts=tuple(role for role in counts if role not in left_out),
        aliases=_ALIASES,
        missing=lambda file, roles: _missing(file, roles, of, example, instrument),
    )
    return layout, of


def _missing(
    file: str,
    roles: Collection[str],
    joints: dict[str, str],
    example: str,
    instrument: str | None,
) -> list[Problem]:
    out = []
    absent = [role for role in joints.values() if role not in roles]
    if absent:
        found = f"no column for {listed(absent)}"
        out.append(Problem(file, "line 1", found, "one column per driven joint", example))
    for group, unit in (
        (POINT, " [mm]"),
        (DIFFERENCE, " [mm]"),
        (TURNS, " [deg]"),
        (QUATERNION, ""),
        (PIXELS, ""),
    ):
        there = [role for role in group if role in roles]
        if there and len(there) < len(group):
            lacking = [role for role in group if role not in roles]
            columns = ", ".join(f"{role}{unit}" for role in group)
            found = f"{listed(there)} without {listed(lacking)}"
            out.append(Problem(file, "line 1", found, "all of them, or none", columns))
    measured = [group[0] for group in (POINT, DIFFERENCE) if set(group) & set(roles)]
    measured += [kind for kind in PARTIAL if kind in roles]
    measured += ["u and v"] if "u" in roles else []
    if "sphere" in roles and "radius" not in roles:
        expected = "the radius of the sphere that the tool point touches"
        out.append(Problem(file, "line 1", "sphere without radius", expected, "radius [mm]"))
    if instrument == "poses" and not {TURNS[0], QUATERNION[0]} & set(roles):
        expected = "the orientation of the tool beside its point"
        out.append(Problem(file, "line 1", "no orientation", expected, "qw, qx, qy, qz"))
    if len(measured) != 1:
        found = f"both {listed(measured)}" if measured else "no measured tool point"
        expected = "columns x, y, z, or dx, dy, dz, or one number; name others by --map"
        if len(measured) > 1:
            expected = f"one kind of measurement, or --instrument, {listed(list(_COLUMNS))}"
        elif instrument is not None:
            expected = f"the columns of --instrument {instrument}"
        out.append(Problem(file, "line 1", found, expected, HEADINGS[instrument or "points"]))
    return out


def _read(
    path: Path, arm: Arm, mapping: Sequence[str], instrument: str | None
) -> CalibrationVisits:
    file = str(path)
    table = read_table(path, _layout(arm, ())[0])
    header, mistakes = read_header(file, read_text(path, MEGABYTES), arm)
    if mistakes:
        refuse_all(mistakes)
    mapped = {text.partition("=")[0].strip() for entry in mapping for text in entry.split(",")}
    layout, of = _layout(arm, [*table.names, *mapped], instrument or header.instrument)
    by_size, remarks = _units_by_size(table, layout, mapped)
    words, values = role_values(table, find_columns(table, [*by_size, *mapping], layout), layout)
    lines = table.lines
    q = np.column_stack([values[role] for role in of.values()])
    mistakes = outside_limits(file, q, lines, arm) + other_units(
        file, values, lines, tool_points(arm, q)
    )
    groups: dict[tuple[str, ...], Floats] = {
        group: np.column_stack([values[role] for role in group])
        for group in (POINT, DIFFERENCE, TURNS, QUATERNION)
        if group[0] in values
    }
    readings = _readings(words, values, header.camera)
    mistakes += mistakes_in_targets(file, readings, lines)
    images = None
    if readings is not None and readings.kind == "tags":
        images, notes, wrong = whole_tags(file, readings, q, values["corner"], lines)
        mistakes += wrong
        remarks += notes
    if len(q) >= FEWEST:
        checked = [("joint values", q)]
        checked += [("measurement", groups[g]) for g in (POINT, DIFFERENCE) if g in groups]
        for what, array in checked:
            if not np.ptp(array, axis=0).any():
                found = f"the same {what} in every row"
                mistakes.append(Problem(file, "", found, "different poses, one per row"))
    if QUATERNION in groups:
        mistakes += not_unit(file, groups[QUATERNION], lines)
    if mistakes:
        refuse_all(mistakes, MOST_MISTAKES)
    approach = np.zeros_like(q)
    for k, joint in enumerate(arm.driven):
        if f"{joint.name} approach" in values:
            approach[:, k] = np.sign(values[f"{joint.name} approach"])
    visits = CalibrationVisits(
        q,
        groups.get(POINT),
        groups.get(DIFFERENCE),
        rotations(groups),
        approach,
        readings,
        file,
        tuple(lines),
        remarks=(*remarks, *header.remarks),
        noise=header.noise,
        sizes=header.sizes,
    )
    return visits if images is None or readings is None else _of_images(visits, readings, images)


def _of_images(
    visits: CalibrationVisits, readings: Readings, images: NDArray[np.int64]
) -> CalibrationVisits:
    """Return visits with one row per whole tag, whose corners stand in the rows of `images`."""
    first = images[:, 0]
    out = replace(visits.rows(first), lines=tuple(visits.lines[k] for k in first))
    names = tuple(readings.target[k] for k in first)
    return replace(out, readings=readings._replace(value=readings.value[images], target=names))


def _readings(
    words: Mapping[str, list[str]], values: Mapping[str, Floats], camera: Camera | None
) -> Readings | None:
    """Return the numbers of a file that has one of each visit; None for another file."""
    if "u" in values:
        names = words.get("tag", ["A"] * len(values["u"]))
        return Readings("tags", np.column_stack([values["u"], values["v"]]), tuple(names), camera)
    kind = next((each for each in PARTIAL if each in words or each in values), None)
    if kind is None:
        return None
    if kind in words:
        names = words[kind]
        value = values["radius"] if kind == "sphere" else np.zeros(len(names))
    else:
        value = values[kind]
        names = words.get(PARTIAL[kind], ["x" if kind in {"dial", "angle"} else "A"] * len(value))
    return Readings(kind, value, tuple(names))


def _units_by_size(
    table: TextTable, layout: Layout, mapped: Collection[str]
) -> tuple[list[str], list[str]]:
    """Return a mapping with the units of columns that state none, by the size of their numbers, and
    a remark for each kind. Roles that are mapped already are left to their mapping.
    """
    largest: dict[str, tuple[str, float]] = {}
    for k, (heading, name) in enumerate(zip(table.header, table.names, strict=True)):
        role = layout.aliases.get(name, name)
        if role in layout.units and "[" not in heading and role not in mapped:
            sizes = [_size(row[k]) for row in table.rows if k < len(row)]
            largest[role] = name, max(sizes, default=0.0)
    chosen, remarks = [], []
    for si, units, limit in (
        ("rad", ("rad", "deg"), _LARGEST_ANGLE),
        ("m", ("m", "mm"), _LARGEST_LENGTH),
    ):
        of = {role: pair for role, pair in largest.items() if layout.units[role][0] == si}
        small = set(of) <= set(DIFFERENCE)
        most = max((size for _, size in of.values()), default=0.0)
        unit = units[most > (_UNIT_LENGTH * _LARGEST_LENGTH / 20 if small and of else limit)]
        chosen += [f"{role} = {name} [{unit}]" for role, (name, _) in of.items()]
        if of:
            listing = listed([name for name, _ in of.values()])
            remarks.append(f"the file states no unit for {listing}: read as {unit} by their size")
    return chosen, remarks


def _size(cell: str) -> float:
    try:
        return abs(numbers([cell.replace(",", ".")])[0])
    except ValueError:
        return 0.0
