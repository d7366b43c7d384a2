"""Columns of the CSV files by which an arm is calibrated: which there may be, what is missing, and
the units of those that state none.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from lostmotion.errors import Problem
from lostmotion.io.limits import cut, listed, nearest
from lostmotion.io.measured.calibration_checks import HEADINGS, PARTIAL, PIXELS, POINT
from lostmotion.io.measured.orientations import QUATERNION, TURNS
from lostmotion.io.measured.table import LONGEST, Layout
from lostmotion.io.text import numbers

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from lostmotion.io.measured.table import Header, TextTable
    from lostmotion.mechanism.arm import Arm

DIFFERENCE: Final = ("dx", "dy", "dz")
# Columns of differences to what was commanded, whose sign a file may state.
SIGNED: Final = (*DIFFERENCE, "dial", "angle")
# Joint values beyond 1.05 turns are degrees, coordinates beyond 20 are millimetres.
_LARGEST_ANGLE: Final = 6.6
_LARGEST_LENGTH: Final = 20.0
_UNIT_LENGTH: Final = 0.02
# Units of joint values, as a heading ends with them.
_JOINT_UNITS: Final = {"rad": ("[deg]", "[rad]", "[°]"), "m": ("[mm]", "[m]")}
# Columns that a file may have beside its measurements, each with its unit.
OPTIONAL: Final = {"time": ("s", "s"), "payload": ("kg", "kg")}
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


def layout_of(
    arm: Arm,
    names: Collection[str],
    instrument: str | None = None,
    with_unit: Collection[str] = (),
) -> tuple[Layout, dict[str, str]]:
    """Return what a file with these headings may hold, and the role of each joint.

    with_unit  the headings that have a unit: a time or a payload without one is not read
    """
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
        **{role: unit for role, unit in OPTIONAL.items() if role in with_unit},
    }
    left_out = set() if instrument is None else _MEASURED - _COLUMNS[instrument]
    words = ("to", "along", "about", "plane", "sphere", "tag", "set")
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


def with_unknown_joints(
    table: TextTable, columns: Header, layout: Layout, of: Mapping[str, str]
) -> Header:
    """Return the columns of a file with a mistake for each unread one that is a joint of another
    arm: a further number of the same name; and where a joint is missing any with its kind of unit.

    of  name of the column of each joint of the arm
    """
    read = {column.index for column in columns.of.values()}
    series = {name.rstrip("0123456789") for name in of.values() if name[-1:].isdigit()}
    lacking = [name for name in of.values() if name not in columns.of]
    out = []
    for index, (heading, name) in enumerate(zip(table.header, table.names, strict=True)):
        numbered = name[-1:].isdigit() and name.rstrip("0123456789") in series
        of_kind = any(
            heading.rstrip().endswith(_JOINT_UNITS[layout.units[role][0]]) for role in lacking
        )
        if index not in read and (numbered or of_kind):
            found = f"{cut(name, LONGEST)}, which is no joint of the arm"
            near = nearest(name, lacking)
            expected = f"its joints: {listed(list(of.values()))}"
            out.append(Problem(table.file, "line 1", found, expected, nearest=near))
    return columns._replace(mistakes=[*columns.mistakes, *out])


def units_by_size(
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
