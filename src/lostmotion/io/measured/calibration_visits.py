"""CSV files of visits by which an arm is calibrated: joint values, and what an instrument read.

    A [deg], B [deg], ..., x [mm], y [mm], z [mm], qw, qx, qy, qz

One row per visit. Joints are named as in the arm's file; joint_1, joint_2, ... are read in order.
x, y and z are the attained tool point; qw to qz, or rx, ry and rz (rotations about the fixed axes,
in that order), its orientation. dx, dy and dz are differences to the commanded point, whose sign a
line above the rows states, `# sign: commanded - attained`; else the fit finds it. `A approach` is
the sign of the last motion of joint A, time [s] that of the visit by any clock, and payload [kg]
the mass at the tool. `set` is the name of the set-up of the instrument, where it was moved.

In their place one number: distance [mm] with `to`, the name of its fixed end; dial [mm] with
`along`, or angle [deg] with `about`, an axis x, y or z of the base; `plane`, the name of a plane
that is touched; `sphere` and radius [mm] the same. Or the four corners of a `tag` on the tool, a
row each: pixels `u` and `v` of a camera that stands still, and the number of the `corner`, 0 to 3.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.calibration.instruments import MeasuredVisits, Readings
from lostmotion.calibration.repeats import common_poses
from lostmotion.errors import Problem
from lostmotion.io.limits import refuse_all
from lostmotion.io.measured.calibration_checks import (
    FEWEST,
    PARTIAL,
    POINT,
    differing,
    equal_rows,
    mistakes_in_sets,
    mistakes_in_targets,
    nameless_sets,
    not_unit,
    other_units,
    out_of_range,
    outside_limits,
    stated_above,
    whole_tags,
)
from lostmotion.io.measured.calibration_columns import (
    DIFFERENCE,
    OPTIONAL,
    SIGNED,
    layout_of,
    units_by_size,
    with_unknown_joints,
)
from lostmotion.io.measured.calibration_header import read_header
from lostmotion.io.measured.difference_sign import stated_sign
from lostmotion.io.measured.orientations import QUATERNION, TURNS, rotations
from lostmotion.io.measured.table import (
    MEGABYTES,
    MOST_MISTAKES,
    find_columns,
    read_table,
    role_values,
)
from lostmotion.io.text import read_text
from lostmotion.mechanism.state import tool_points

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import Self

    from numpy.typing import NDArray

    from lostmotion.calibration.instruments import Camera
    from lostmotion.calibration.terms import Deviations
    from lostmotion.io.measured.instrument import Instrument
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_SAME_JOINTS: Final = 1e-9


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

    def rows(self, kept: NDArray[np.int64]) -> Self:
        """Return the visits in these rows, with their lines."""
        lines = tuple(self.lines[k] for k in kept) if self.lines else ()
        return replace(super().rows(kept), lines=lines)


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
    unsigned = next((each.file for each in found if not each.signed), "")
    if unsigned and any(each.signed for each in found):
        example = "# sign: commanded - attained"
        expected = "a line that states the sign of differences in all files, or in none"
        mistakes.append(Problem(unsigned, "sign", "nothing", expected, example))
    if mistakes:
        refuse_all(mistakes)
    timed = [each.time is not None for each in found]
    times = _joined([each.time for each in found]) if all(timed) else None
    unused = ["some of the files state no time: it is not used"] if any(timed) > all(timed) else []
    sets, notes = _sets(found)
    digest = hashlib.blake2b(digest_size=16)
    for each in files:
        digest.update(Path(each).read_bytes())
    joined = replace(
        found[0],
        q=common_poses(np.concatenate([each.q for each in found])),
        point=_joined([each.point for each in found]),
        difference=_joined([each.difference for each in found]),
        rotation=_joined([each.rotation for each in found]),
        approach=np.concatenate([np.asarray(each.approach) for each in found]),
        time=times,
        payload=_payloads(found, arm),
        lines=tuple(line for each in found for line in each.lines),
        readings=_joined_readings([each.readings for each in found if each.readings]),
        remarks=(*dict.fromkeys(text for each in found for text in each.remarks), *unused, *notes),
        digest=digest.hexdigest(),
        sets=sets,
    )
    file_of = [each.file for each in found for _ in each.lines]
    if wrong := mistakes_in_sets(joined, file_of, joined.lines):
        refuse_all(wrong)
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


def _payloads(visits: Sequence[CalibrationVisits], arm: Arm) -> Floats | None:
    """Return the payload at each visit (visit,), kg: that of the arm's file where none is stated;
    None where none is stated at all.
    """
    if all(each.payload is None for each in visits):
        return None
    own = arm.payload.mass or 0.0
    parts = [np.full(len(each), own) if each.payload is None else each.payload for each in visits]
    return np.concatenate(parts)


def _sets(
    visits: Sequence[CalibrationVisits],
) -> tuple[NDArray[np.str_] | None, list[str]]:
    """Return the name of the set of each visit, None where all are of one; and a remark on files
    that name none, whose rows are one set together.
    """
    names = [name for each in visits for name in _set_names(each)]
    if len(set(names)) == 1:
        return None, []
    note = "files without a column set: their rows are one set of their own"
    return np.array(names), [note] if "" in names else []


def _set_names(visits: CalibrationVisits) -> list[str]:
    return [""] * len(visits) if visits.sets is None else visits.sets.tolist()


def _without_duplicates(visits: CalibrationVisits) -> CalibrationVisits:
    """Return visits without those that repeat another one in everything that was read.

    A gauge may well show one number twice: equal readings of one number are repeated measurements
    where other readings of one pose differ.
    """
    parts = (visits.approach, visits.time, visits.payload)
    read = visits.readings
    targets = ("",) * len(visits) if read is None else read.target
    names = list(zip(targets, _set_names(visits), strict=True))
    poses = _rows_of([np.round(visits.q / _SAME_JOINTS), *parts], names)
    values = (visits.point, visits.difference, visits.rotation, read and read.value)
    rows = _rows_of(values, poses)
    first = {row: k for k, row in reversed(list(enumerate(rows)))}
    scatter = len({poses[k] for k in first.values()}) < len(first)
    if read is not None and read.kind != "tags" and scatter:
        return visits
    kept = np.array(sorted(first.values()))
    return replace(visits.rows(kept), duplicates=len(visits) - len(kept))


def _rows_of(values: Sequence[Any], names: Sequence[Any]) -> list[Any]:
    """Return a key of each row of these arrays (row, ...), of which some may be absent, and names
    (row,).
    """
    arrays = [each + 0.0 for each in values if isinstance(each, np.ndarray)]  # no negative zero
    return [(name, *(array[k].tobytes() for array in arrays)) for k, name in enumerate(names)]


def _read(
    path: Path, arm: Arm, mapping: Sequence[str], instrument: str | None
) -> CalibrationVisits:
    file = str(path)
    table = read_table(path, layout_of(arm, ())[0])
    header, mistakes = read_header(file, read_text(path, MEGABYTES), arm)
    if mistakes:
        refuse_all(mistakes)
    mapped = {text.partition("=")[0].strip() for entry in mapping for text in entry.split(",")}
    united = {
        name for heading, name in zip(table.header, table.names, strict=True) if "[" in heading
    }
    names = [*table.names, *mapped]
    layout, of = layout_of(arm, names, instrument or header.instrument, united | mapped)
    by_size, remarks = units_by_size(table, layout, mapped)
    columns = find_columns(table, [*by_size, *mapping], layout)
    sign, columns = stated_sign(table, with_unknown_joints(table, columns, layout, of), SIGNED)
    words, values = role_values(table, columns, layout)
    if sign:
        values |= {role: sign * values[role] for role in SIGNED if role in values}
    lines = table.lines
    q = np.column_stack([values[role] for role in of.values()])
    sets = np.array(words["set"]) if "set" in words else None
    mistakes = outside_limits(file, q, lines, arm)
    for rows in MeasuredVisits(q, sets=sets).by_set.values():
        here = {role: each[rows] for role, each in values.items()}
        mistakes += other_units(file, here, [lines[k] for k in rows], tool_points(arm, q[rows]))
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
    mistakes += equal_rows(file, q, [groups[g] for g in (POINT, DIFFERENCE) if g in groups])
    if QUATERNION in groups:
        mistakes += not_unit(file, groups[QUATERNION], lines)
    mistakes += out_of_range(file, values, lines)
    mistakes += nameless_sets(file, words["set"], lines) if "set" in words else []
    unread = [role for role in OPTIONAL if role in table.names and role not in values]
    remarks += [f"the column {role} states no unit: it is not used" for role in unread]
    if mistakes:
        refuse_all(mistakes, MOST_MISTAKES)
    approach = np.zeros_like(q)
    for k, joint in enumerate(arm.driven):
        if f"{joint.name} approach" in values:
            approach[:, k] = np.sign(values[f"{joint.name} approach"])
    payload = values.get("payload")
    if payload is None and header.payload is not None:
        payload = np.full(len(q), header.payload)
    visits = CalibrationVisits(
        q,
        groups.get(POINT),
        groups.get(DIFFERENCE),
        rotations(groups),
        approach,
        readings,
        values.get("time"),
        payload,
        signed=bool(sign),
        file=file,
        lines=tuple(lines),
        remarks=(*remarks, *header.remarks),
        noise=header.noise,
        sizes=header.sizes,
        sets=sets,
    )
    return visits if images is None or readings is None else _of_images(visits, readings, images)


def _of_images(
    visits: CalibrationVisits, readings: Readings, images: NDArray[np.int64]
) -> CalibrationVisits:
    """Return visits with one row per whole tag, whose corners stand in the rows of `images`."""
    first = images[:, 0]
    out = visits.rows(first)
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
