"""Mistakes in the measurements of a calibration: values beyond the joint limits, mixed units,
quaternions that are none, and targets without enough readings.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.calibration.sets import FEWEST_IN_SET, set_in_words, small_sets
from lostmotion.calibration.terms import Deviations
from lostmotion.errors import Problem, shown
from lostmotion.io.measured.table import MOST_MISTAKES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from lostmotion.calibration.instruments import MeasuredVisits, Readings
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

POINT: Final = ("x", "y", "z")
# One number of each visit: its column, and that of what it is measured of.
PARTIAL: Final = {"distance": "to", "dial": "along", "angle": "about", "plane": "", "sphere": ""}
PIXELS: Final = ("u", "v", "corner")
# Headings that would pass, by instrument.
HEADINGS: Final = {
    "tracker": "x [mm], y [mm], z [mm]",
    "points": "x [mm], y [mm], z [mm]",
    "poses": "x [mm], y [mm], z [mm], qw, qx, qy, qz",
    "distance": "distance [mm], to",
    "plane": "plane",
    "sphere": "sphere, radius [mm]",
    "dial": "dial [mm], along",
    "inclinometer": "angle [deg], about",
    "tags": "u, v, corner, tag",
}
FEWEST: Final = 3
_CORNERS: Final = (0, 1, 2, 3)
_NOTHING: Final = "nothing"
# A value outside the joint limits by less is rounding, rad or m.
_BESIDE: Final = 1e-6
# Shortest distance and radius, m, and longest time, s.
_LEAST_LENGTH: Final = 1e-4
_LONGEST_TIME: Final = 1e12
# Smallest area of a tag in an image, px^2.
_AREA: Final = 1.0
# A row that is so many times as far from the others as they are from each other has another unit,
# and so has a column whose extent differs by so much more than that of the nominal points.
_OTHER_UNIT: Final = 100.0
_UNEQUAL: Final = 30.0


def outside_limits(file: str, q: Floats, lines: Sequence[int], arm: Arm) -> list[Problem]:
    """Return joint values outside the joint limits."""
    low, high = arm.limits.T
    wrong = np.argwhere((q < low - _BESIDE) | (q > high + _BESIDE))
    out = []
    for row, k in wrong[: MOST_MISTAKES + 1]:
        joint = arm.driven[k]
        factor, unit = (1e3, "mm") if joint.type == "prismatic" else (180 / np.pi, "deg")
        found = f"{factor * q[row, k]:.4g} {unit}"
        expected = (
            f"from {factor * low[k]:.4g} to {factor * high[k]:.4g} {unit}, the joint's limits"
        )
        out.append(Problem(file, f"line {lines[row]}, {joint.name}", found, expected))
    return out


def other_units(
    file: str, values: Mapping[str, Floats], lines: Sequence[int], nominal: Floats
) -> list[Problem]:
    """Return columns of coordinates that extend a thousand times as far as the others, or a
    thousandth, where the nominal points (visit, 3) do not, and rows that are far from all others.
    """
    if "x" not in values or len(lines) < FEWEST:
        return []
    points, out = np.column_stack([values[role] for role in POINT]), []
    extent = np.maximum(np.ptp(points, axis=0), 1e-12)
    sizes = np.linalg.svd(nominal - nominal.mean(axis=0), compute_uv=False)
    small, middle, large = np.argsort(extent)
    if extent[large] / extent[small] > _UNEQUAL * sizes[0] / max(sizes[2], 1e-3 * sizes[0]):
        above = extent[large] / extent[middle] > extent[middle] / extent[small]
        role = POINT[large if above else small]
        ratio = extent[large if above else small] / extent[middle]
        found = f"{role}, about {ratio:.2g} times as large as the other coordinates"
        out.append(Problem(file, f"line 1, {role}", found, "one unit for all three"))
    beside = np.linalg.norm(points - np.median(points, axis=0), axis=1)
    usual = float(np.median(beside))
    for row in map(int, np.flatnonzero(beside > _OTHER_UNIT * usual)):
        found = f"{beside[row]:.3g} m from the other rows"
        out.append(Problem(file, f"line {lines[row]}", found, "one unit for all rows"))
    return out


def not_unit(file: str, quaternions: Floats, lines: Sequence[int]) -> list[Problem]:
    """Return quaternions (visit, 4) whose length differs from 1 by more than a thousandth."""
    lengths = np.linalg.norm(quaternions, axis=1)
    return [
        Problem(
            file,
            f"line {lines[row]}, qw to qz",
            f"a length of {lengths[row]:.4g}",
            "a quaternion of length 1",
            "1, 0, 0, 0",
        )
        for row in np.flatnonzero(np.abs(lengths - 1) > 1e-3)[: MOST_MISTAKES + 1]  # noqa: PLR2004
    ]


def equal_rows(file: str, q: Floats, measured: Sequence[Floats]) -> list[Problem]:
    """Return joint values (visit, joint) and measurements (visit, 3) that are one in every row."""
    named = [("joint values", q), *(("measurement", each) for each in measured)]
    return [
        Problem(file, "", f"the same {what} in every row", "different poses, one per row")
        for what, array in named
        if len(q) >= FEWEST and not np.ptp(array, axis=0).any()
    ]


def out_of_range(file: str, values: Mapping[str, Floats], lines: Sequence[int]) -> list[Problem]:
    """Return payloads below zero, distances and radii that are none, times beyond any clock, and
    angles beyond a half turn.
    """
    out = []
    for role, low, high, unit, example in (
        ("payload", 0.0, np.inf, "kg", "2"),
        ("distance", _LEAST_LENGTH, np.inf, "m", "500 mm"),
        ("radius", _LEAST_LENGTH, np.inf, "m", "12.7 mm"),
        ("time", -_LONGEST_TIME, _LONGEST_TIME, "s", "30"),
        ("angle", -np.pi, np.pi, "rad", "0.1 deg"),
    ):
        found = values.get(role, np.zeros(0))
        expected = f"at most {high:.3g} {unit}" if high < np.inf else f"{low:g} {unit} or more"
        out += [
            Problem(file, f"line {lines[row]}, {role}", f"{found[row]:g} {unit}", expected, example)
            for row in np.flatnonzero((found < low) | (found > high))[:MOST_MISTAKES]
        ]
    return out


def mistakes_in_targets(
    file: str, readings: Readings | None, lines: Sequence[int]
) -> list[Problem]:
    """Return axes that are none, and targets with fewer readings than they have unknowns."""
    if readings is None or readings.kind == "tags":
        return []
    if readings.kind in {"dial", "angle"}:
        wrong = [k for k, name in enumerate(readings.target) if name not in {"x", "y", "z"}]
        return [
            Problem(
                file,
                f"line {lines[k]}, {PARTIAL[readings.kind]}",
                shown(readings.target[k]),
                "an axis of the base: x, y or z",
                "z",
            )
            for k in wrong[:MOST_MISTAKES]
        ]
    fewest = {"distance": 5, "plane": 4, "sphere": 5}[readings.kind]
    return [
        Problem(
            file,
            f"{readings.kind} {shown(name)}",
            f"{count} readings",
            f"at least {fewest}: it has {fewest - 1} unknowns of its own",
        )
        for name, count in Counter(readings.target).items()
        if count < fewest
    ]


def mistakes_in_sets(
    visits: MeasuredVisits, files: Sequence[str], lines: Sequence[int]
) -> list[Problem]:
    """Return sets with too few poses, and several sets of an instrument whose place is estimated.

    files, lines  of each visit
    """
    of = visits.by_set
    if visits.readings is not None and len(of) > 1:
        expected = "points, differences or poses, or rows of one set-up"
        kind = visits.readings.kind
        if kind in {"distance", "plane", "sphere"}:
            column = PARTIAL[kind] or kind
            expected += f"; without the column set, another name in {column} for each set-up"
        found = f"{len(of)} sets of {kind} readings"
        return [Problem(files[0], "line 1, set", found, expected)]
    least = f"at least {FEWEST_IN_SET} poses in each set, which determine its frame: measure more, "
    least += "or remove these rows"
    return [
        Problem(
            files[rows[0]],
            set_in_words(name),
            f"{len(rows)} rows at fewer than {FEWEST_IN_SET} poses, line "
            + ", ".join(str(lines[k]) for k in rows[:MOST_MISTAKES]),
            least,
        )
        for name, rows in small_sets(visits).items()
    ]


def nameless_sets(file: str, names: Sequence[str], lines: Sequence[int]) -> list[Problem]:
    """Return rows whose cell in the column set is empty."""
    expected = "the name of the set-up of the instrument in every row, or no column set"
    return [
        Problem(file, f"line {line}, set", "nothing", expected, "day 2")
        for name, line in zip(names, lines, strict=True)
        if not name
    ][:MOST_MISTAKES]


def whole_tags(
    file: str, readings: Readings, q: Floats, corner: Floats, lines: Sequence[int]
) -> tuple[NDArray[np.int64], list[str], list[Problem]]:
    """Return the rows of the four corners of each image that shows a tag whole (image, 4), a
    remark on other images, and mistakes: a camera that is not stated, corners that are none, and
    tags seen whole at too few poses. A corner that repeats at a pose begins a new image.
    """
    out = []
    if readings.camera is None:
        example = "# camera: fx 800, fy 800, cx 320, cy 240 and # tag size: 40 mm"
        out.append(Problem(file, "", "pixels without a camera", "lines above the rows", example))
    seen: dict[tuple[str, bytes], list[dict[float, int]]] = {}
    for k, (name, pose, number) in enumerate(zip(readings.target, q, corner, strict=True)):
        if number not in _CORNERS:
            found = f"{number:g}"
            expected = "0 to 3, counter-clockwise from the lower left as the tag is seen"
            out.append(Problem(file, f"line {lines[k]}, corner", found, expected, "0"))
        here = seen.setdefault((name, pose.tobytes()), [{}])
        if number in here[-1]:
            here.append({})
        here[-1][number] = k
    every = [(key, rows) for key, images in seen.items() for rows in images]
    whole = [(key, rows) for key, rows in every if len(rows) == len(_CORNERS)]
    count = Counter(name for name, _ in {key for key, _ in whole})
    for name in dict.fromkeys(readings.target):
        if count[name] < FEWEST:
            found = f"{count[name]} poses at which all four corners are seen"
            out.append(Problem(file, f"tag {shown(name)}", found, f"at least {FEWEST}"))
    images = sorted([rows[number] for number in sorted(rows)] for _, rows in whole)
    kept = np.array(images, dtype=np.int64).reshape(-1, 4)
    partly = len(every) - len(whole)
    out += _flat(file, readings.value[kept], [lines[k] for k in kept[:, 0].tolist()])
    unused = f"images in {file} without all four corners of a tag, not used: {partly}"
    remarks = [unused] if partly else []
    return kept, remarks, out[:MOST_MISTAKES]


def _flat(file: str, corners: Floats, lines: Sequence[int]) -> list[Problem]:
    """Return images (image, 4, 2), px, in which a tag has no area."""
    one, two = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    area = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]) / 2
    return [
        Problem(
            file,
            f"line {lines[int(k)]}, u and v",
            f"a tag of {area[k]:.3g} px^2",
            f"four corners around {_AREA:g} px^2 or more, one after another",
        )
        for k in np.flatnonzero(area < _AREA)
    ]


def differing(stated: Sequence[tuple[str, Mapping[str, str]]]) -> list[Problem]:
    """Return what files of one calibration state differently above their rows.

    stated  each file with what it states (`stated_above`)
    """
    (first, here), *others = stated
    out = []
    for file, there in others:
        for key, text in here.items():
            if text != there[key]:
                expected = f"{text}, as in {first}: one value for all files"
                example = f"no line # {key}" if text == _NOTHING else f"# {key}: {text}"
                out.append(Problem(file, key, there[key], expected, example))
    return out


def stated_above(
    noise: float | None, sizes: Deviations | None, readings: Readings | None
) -> dict[str, str]:
    """Return what the comments of a file state, as text by key: noise, deviations, camera and size
    of the tags.
    """
    camera = readings and readings.camera
    usual = Deviations()
    deviations = [
        f"{name} {1e3 * value:g} {'mm' if 'shift' in name else 'mrad'}"
        for name, value in ({} if sizes is None else vars(sizes)).items()
        if value != getattr(usual, name) or name == "turn"
    ]
    of_camera = "" if camera is None else "fx {:g}, fy {:g}, cx {:g}, cy {:g}".format(*camera)
    return {
        "noise": _NOTHING if noise is None else f"{1e6 * noise:g} µm",
        "deviations": ", ".join(deviations) or _NOTHING,
        "camera": of_camera or _NOTHING,
        "tag size": _NOTHING if camera is None else f"{1e3 * camera.size:g} mm",
    }
