"""Path accuracy AT and path repeatability RT (ISO 9283:1998, 8.2, 8.3) of a measured robot, from
readings along straight paths.

Where all cycles were read at the same places, AT and RT are those of the readings there. A tracker
that reads at its own clock never reads twice at one place: then each cycle's nearest reading is
moved to evenly spaced planes normal to the commanded path.
"""

from __future__ import annotations

import functools
import math
import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.visit_intervals import MIN_VISITS, UNKNOWN, generator
from lostmotion.error_model.worst_plane import largest_mean, largest_scatter
from lostmotion.errors import InputError, Problem, shown
from lostmotion.laws import iso9283 as iso
from lostmotion.laws.iso9283 import (
    MIN_READINGS,
    across_path,
    moved_to_planes,
    path_figures,
    shared_places,
)

if TYPE_CHECKING:
    from collections.abc import Container

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.io.measured.visits import Visits
    from lostmotion.spatial import Floats

# Planes, as many as along a predicted path; at most as many as a cycle has readings.
PLANES: Final = 20
# Most planes from which intervals are computed, evenly picked: the cost grows with their square.
MOST_PLANES: Final = 60
# Commanded positions along a path that define its line where its name does not.
MIN_COMMANDS: Final = 2
MOST_CYCLES: Final = 1000
MOST_PATHS: Final = 20
# As a share of the path's length: how far a reading may go back (noise at rest, overshoot), and how
# much all cycles must cover.
_BACK: Final = 0.01
_COVERED: Final = 0.5
# Rounding of commanded positions (m) and orientations (rad) in the file, and tolerated deviation
# from the straight line.
_SAME: Final = 1e-3
_SHORTEST: Final = 1e-6
_MOST_MISTAKES: Final = 20
_SETS: Final = 400
_NAMES: Final = re.compile(r"\s+to\s+|\s*[->]+\s*|\s+")
_EXAMPLE: Final = (
    "P2-P4, with P2 and P4 commanded in the same file, by --commands, or by --cube and --centre"
)


@dataclass(frozen=True)
class MeasuredPath:
    """One path under one load: lengths in m, angles in rad.

    name               its ends, "P2-P4"
    ends (2, 3)        of the commanded line
    cycles, readings   number of cycles, and of readings in all
    shared             all cycles were read at the same places, which are the planes
    places (plane,)    position of each plane along the path
    figures (8)        `PATH_FIGURES` of these cycles as the standard defines them, at the worst
                       plane; NaN where orientations are unknown many (8)           estimates for
                       many cycles, with confidence intervals; the worst of several planes of few
                       cycles is biased high
    worst (8,)         position of the worst plane for each figure
    profile (8, plane) the figures at each plane
    floor              RT_p expected from the instrument alone
    gap                largest distance between neighbouring readings along the path
    missed             r.m.s. distance of a reading from the straight line between its two
                       neighbours, across the path
    """

    name: str
    ends: Floats
    cycles: int
    readings: int
    shared: bool
    places: Floats
    figures: Floats
    many: tuple[Estimate, ...]
    worst: Floats
    profile: Floats
    floor: float
    gap: float
    missed: float

    @property
    def length(self) -> float:
        """Return the length of the commanded line, m."""
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))


@dataclass(frozen=True)
class _Line:
    """A commanded line: label, start, unit direction, length, and the tool's rotation along it (NaN
    where unknown).
    """

    name: str
    start: Floats
    along: Floats
    length: float
    rotation: Floats


def evaluate_paths(readings: Visits, level: float) -> tuple[MeasuredPath, ...]:
    """Return the path characteristics of readings along paths under one load, with confidence
    intervals of this level.

    The command is the line between the two poses that a path is named after. Commanded positions in
    the file must lie on a straight line, and define it where the name does not. Raises InputError
    for a path without a known command, cycles with fewer than five readings or out of order, fewer
    than two cycles, and readings along less than half of the path.
    """
    out: dict[str, MeasuredPath] = {}
    mistakes: list[Problem] = []
    if len(labels := dict.fromkeys(readings.path)) > MOST_PATHS:
        raise InputError(
            [
                _problem(
                    readings,
                    0,
                    f"{len(labels)} paths",
                    f"at most {MOST_PATHS}",
                    "the names of two poses, P2-P4",
                )
            ]
        )
    for label in labels:
        rows = readings.picked(np.array([path == label for path in readings.path]))
        try:
            line = _line(label, rows)
            judged = _evaluate_path(line, rows, level)
        except InputError as error:
            mistakes += error.problems
        else:
            if out.setdefault(line.name, judged) is not judged:
                mistakes.append(
                    _problem(
                        rows,
                        0,
                        f"path {line.name} under a second name",
                        "one name for each path",
                        line.name,
                    )
                )
    if mistakes:
        raise InputError(mistakes[:_MOST_MISTAKES])
    return tuple(out.values())


def path_ends(label: str, known: Container[str]) -> tuple[str, str] | None:
    """Return the two known poses that a path's name joins ("P2-P4", "P2 P4" or "P2 to P4"); None
    where it names no two.
    """
    for found in _NAMES.finditer(label):
        a, b = label[: found.start()].strip(), label[found.end() :].strip()
        if a != b and a in known and b in known:
            return a, b
    return None


def _problem(rows: Visits, k: int, found: str, expected: str, example: str) -> Problem:
    file, line = rows.where[k]
    return Problem(file, f"line {line}", found, expected, example)


def _line(label: str, rows: Visits) -> _Line:
    """Return the commanded line of a path."""
    stated = np.flatnonzero(np.isfinite(rows.command).all(axis=1))
    named = path_ends(label, rows.known)
    turned = rows.rotation[np.isfinite(rows.rotation).all(axis=(1, 2))]
    if named is not None:
        ends = np.stack([rows.known[each] for each in named])
        start, end = ends[:, :3, 3]
        name = "-".join(named)
        turned = np.concatenate([turned, ends[:, :3, :3]])
    elif len(stated) >= MIN_COMMANDS:
        points = rows.command[stated]
        start = points[0]
        end = points[np.linalg.norm(points - start, axis=1).argmax()]
        name = label
    else:
        found = f"path {shown(label)}, which does not name two poses with known commanded positions"
        raise InputError(
            [_problem(rows, 0, found, "two poses with a known command, joined by -", _EXAMPLE)]
        )
    length = float(np.linalg.norm(end - start))
    if length < _SHORTEST:
        raise InputError(
            [
                _problem(
                    rows, 0, f"path {shown(label)} from a point to itself", "two places", _EXAMPLE
                )
            ]
        )
    along = (end - start) / length
    off = np.linalg.norm(across_path(rows.command[stated] - start, along), axis=1)
    if (bent := stated[off > _SAME]).size:
        found = f"a commanded position {off.max() * 1e3:.3f} mm off the line of path {shown(label)}"
        raise InputError(
            [
                _problem(
                    rows,
                    int(bent[0]),
                    found,
                    "a straight commanded path",
                    "the commanded positions along P2-P4, or none",
                )
            ]
        )
    constant = (
        len(turned) > 0
        and bool(np.isfinite(turned).all())
        and float(np.abs(turned - turned[0]).max()) < _SAME
    )
    return _Line(name, start, along, length, turned[0] if constant else np.full((3, 3), math.nan))


def _evaluate_path(line: _Line, rows: Visits, level: float) -> MeasuredPath:
    """Return the characteristics of one path."""
    numbers = dict.fromkeys(rows.cycle.tolist())
    if not MIN_VISITS <= len(numbers) <= MOST_CYCLES:
        found = f"path {line.name} in {len(numbers)} cycle{'s' * (len(numbers) > 1)}"
        expected = f"2 to {MOST_CYCLES} cycles; the standard asks for 10"
        raise InputError(
            [_problem(rows, 0, found, expected, "cycle 1 to 10, each along the whole path")]
        )
    cycles = {cycle: np.flatnonzero(rows.cycle == cycle) for cycle in numbers}
    way = (rows.attained - line.start) @ line.along
    if mistakes := _out_of_order(line, rows, cycles, way):
        raise InputError(mistakes)
    first, last = (
        max(way[at].min() for at in cycles.values()),
        min(way[at].max() for at in cycles.values()),
    )
    first, last = max(first, 0.0), min(last, line.length)
    if last - first < _COVERED * line.length:
        late, early = (
            max(cycles, key=lambda c: way[cycles[c]].min()),
            min(cycles, key=lambda c: way[cycles[c]].max()),
        )
        found = (
            f"path {line.name} of {line.length * 1e3:.1f} mm: cycle {late:g} begins "
            f"{way[cycles[late]].min() * 1e3:.1f} mm along it, "
            f"cycle {early:g} ends {way[cycles[early]].max() * 1e3:.1f} mm along it"
        )
        expected = (
            "readings along at least half of the path in every cycle, in the base frame of its "
            "commands"
        )
        raise InputError(
            [_problem(rows, int(cycles[late][0]), found, expected, "readings from P2 to P4")]
        )
    turned = (
        rows
        if np.isfinite(rows.rotation).all()
        else replace(rows, rotation=np.broadcast_to(line.rotation, rows.rotation.shape))
    )
    errors = np.concatenate(
        [turned.turn, across_path(rows.attained - line.start, line.along)], axis=1
    )
    ways, read = [way[at] for at in cycles.values()], [errors[at] for at in cycles.values()]
    if (shared := _within(shared_places(ways), ways, first, last, line.length)) is not None:
        places = np.mean([each[at] for each, at in zip(ways, shared, strict=True)], axis=0)
        there = np.stack([each[at] for each, at in zip(read, shared, strict=True)], axis=1)
    else:
        places = np.linspace(first, last, min(PLANES, *(len(each) for each in ways)))
        there = moved_to_planes(ways, read, places)
    between = _reading_gaps([(way[at], rows.attained[at]) for at in cycles.values()], line.along)
    return _path_result(line, there, places, rows, level, between, shared=shared is not None)


def _within(
    shared: list[np.ndarray] | None, ways: list[Floats], first: float, last: float, length: float
) -> list[np.ndarray] | None:
    """Return the shared readings on the commanded line; None where they cover too little of it."""
    if shared is None:
        return None
    places = np.mean([way[at] for way, at in zip(ways, shared, strict=True)], axis=0)
    # Noise at the ends of the path puts half of the readings there beyond them.
    on_line = (places >= -_BACK * length) & (places <= (1 + _BACK) * length)
    if on_line.sum() < MIN_READINGS or np.ptp(places[on_line]) < _COVERED * (last - first):
        return None
    return [at[on_line] for at in shared]


def _reading_gaps(cycles: list[tuple[Floats, Floats]], along: Floats) -> tuple[float, float]:
    """Return the largest distance of neighbouring readings along the path, and the r.m.s. error of
    interpolating a reading from its neighbours.
    """
    gap, missed = 0.0, []
    for way, attained in cycles:
        order = np.argsort(way, kind="stable")
        ways, points = way[order], attained[order]
        gap = max(gap, float(np.diff(ways).max()))
        wide = np.maximum(ways[2:] - ways[:-2], np.finfo(float).tiny)
        chord = points[:-2] + ((ways[1:-1] - ways[:-2]) / wide)[:, None] * (
            points[2:] - points[:-2]
        )
        missed.append(across_path(points[1:-1] - chord, along))
    return gap, math.sqrt(float((np.concatenate(missed) ** 2).sum(axis=1).mean()))


def _out_of_order(
    line: _Line, rows: Visits, cycles: dict[float, np.ndarray], way: Floats
) -> list[Problem]:
    """Return the mistakes of cycles with too few readings or with readings that go back."""
    out = []
    for cycle, at in cycles.items():
        if len(at) < MIN_READINGS:
            found = f"{len(at)} readings along path {line.name} in cycle {cycle:g}"
            out.append(
                _problem(
                    rows,
                    int(at[0]),
                    found,
                    f"at least {MIN_READINGS} in every cycle",
                    "readings every 10 mm",
                )
            )
            continue
        behind = np.maximum.accumulate(way[at]) - way[at]
        if (back := np.flatnonzero(behind > _BACK * line.length)).size:
            found = (
                f"{behind[back[0]] * 1e3:.1f} mm back along path {line.name}, in cycle {cycle:g}"
            )
            expected = (
                "readings in the order of motion, from the first end of the path to the second; "
                "the return is a separate path"
            )
            out.append(
                _problem(
                    rows,
                    int(at[back[0]]),
                    found,
                    expected,
                    "path P2-P4 for the motion there, P4-P2 for the return",
                )
            )
    return out[:_MOST_MISTAKES]


def _path_result(
    line: _Line,
    errors: Floats,
    places: Floats,
    rows: Visits,
    level: float,
    between: tuple[float, float],
    *,
    shared: bool,
) -> MeasuredPath:
    """Return the characteristics of errors (plane, cycle, 6), with estimates and intervals for many
    cycles.
    """
    profile = np.stack([path_figures(each, line.along) for each in errors], axis=-1)
    worst = profile.argmax(axis=1)
    picked = errors[np.unique(np.linspace(0, len(errors) - 1, MOST_PLANES).round().astype(int))]
    across, turn = across_path(picked[..., 3:], line.along), picked[..., :3]
    many = [
        largest_mean(across, level),
        largest_scatter(across, level),
        *(largest_mean(turn[..., k : k + 1], level) for k in range(3)),
        *(largest_scatter(turn[..., k : k + 1], level) for k in range(3)),
    ]
    known = np.array([bool(np.isfinite(each).all()) for each in profile])
    return MeasuredPath(
        line.name,
        np.stack([line.start, line.start + line.length * line.along]),
        errors.shape[1],
        len(rows.path),
        shared,
        places,
        np.where(known, profile.max(axis=1), math.nan),
        tuple(each if ok else UNKNOWN for each, ok in zip(many, known, strict=True)),
        np.where(known, places[worst], math.nan),
        profile,
        rows.instrument * _noise(len(picked), errors.shape[1]),
        *between,
    )


@functools.cache
def _noise(planes: int, cycles: int) -> float:
    """Return the RT_p expected at the worst of so many planes from readings of unit standard
    deviation in each coordinate.
    """
    sets = generator("path noise").standard_normal((_SETS, planes, cycles, 2))
    return float(iso.pose_repeatability(sets).max(axis=1).mean())
