"""ISO 9283 characteristics of one measured robot, with confidence intervals (`confidence`)."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.visit_intervals import (
    LEVEL,
    MIN_VISITS,
    UNKNOWN,
    accuracy_interval,
    generator,
    isotropic_repeatability,
    length_interval,
    outlying_visits,
    repeatability_interval,
    scatter_interval,
    student_interval,
    without_instrument,
)
from lostmotion.errors import InputError, Problem
from lostmotion.laws.frame_fit import Fit, best_fit, residual_after_fit
from lostmotion.standards.axis_positioning import axis_positionings
from lostmotion.standards.measured_paths import MeasuredPath, evaluate_paths

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.io.measured.visits import Visits
    from lostmotion.spatial import Floats
    from lostmotion.standards.axis_positioning import AxisPositioning

_RESAMPLES: Final = 400
_FRAME: Final = 3
# Fewest poses for bootstrap intervals.
_MIN_POSES: Final = 20


@dataclass(frozen=True)
class MeasuredPose:
    """One pose: lengths in m, angles in rad; estimates are NaN where visits or the command are
    missing.

    accuracy, repeatability   AP_p and RP_l
    axes (6)                  AP_a, AP_b, AP_c, AP_x, AP_y, AP_z
    scatter (6)               3 s about and along the axes: RP_a, RP_b, RP_c first
    without_instrument        RP_l with the instrument's own scatter subtracted in squares, never
                              below zero
    fitted                    AP_p with the best-fit frames over all poses
    multi_directional         vAP_p, from visits with a side; NaN without
    rotation (3, 3)           orientation of the tool: commanded, or the mean of the attained ones;
                              NaN where none was measured
    errors (visit, 3)         relative to the command, or to the barycentre where the command is
                              unknown
    outlying                  file and line of each visit that lies far from the others
                              (`outlying_visits`), with its distance from their median, m
    without_outlying          RP_l without these visits; NaN where there are none
    accuracy_without          AP_p without these visits, likewise
    """

    name: str
    visits: int
    command: Floats
    accuracy: Estimate
    repeatability: Estimate
    axes: tuple[Estimate, ...]
    scatter: tuple[Estimate, ...]
    without_instrument: Estimate
    fitted: float
    multi_directional: Estimate
    rotation: Floats
    errors: Floats
    outlying: tuple[tuple[str, int, float], ...]
    without_outlying: Estimate
    accuracy_without: Estimate


@dataclass(frozen=True)
class MeasuredLoad:
    """Characteristics of one robot under one load.

    load        share of the payload
    side        side from which every pose was approached, where the file states one for each visit;
                empty for the standard's cycle
    poses       each pose, in natural order of the names
    distance    AD_p and RD between P2 and P4; None without both
    pooled      mean, standard deviation, 95th percentile and maximum of AP_p over poses, as
                commanded and with best-fit frames; intervals over poses
    fit         the best-fit frames; None for fewer than three poses or without commands
    floor       RP_l expected from the instrument alone, m
    paths       each path
    axes        lines of poses along an axis, approached from two sides (ISO 230-2); with the first
                side of a load
    """

    load: float
    poses: tuple[MeasuredPose, ...]
    distance: tuple[Estimate, Estimate] | None
    pooled: tuple[tuple[Estimate, ...], tuple[Estimate, ...]] | None
    fit: Fit | None
    floor: float
    paths: tuple[MeasuredPath, ...]
    side: str = ""
    axes: tuple[AxisPositioning, ...] = ()


@dataclass(frozen=True)
class MeasuredRobot:
    """Characteristics of one robot for each load, the heaviest first."""

    visits: Visits
    loads: tuple[MeasuredLoad, ...]


def evaluate(visits: Visits, level: float = LEVEL) -> MeasuredRobot:
    """Return the ISO 9283 characteristics of these rows, with confidence intervals of this level.

    A scatter needs two visits, best-fit frames three poses. Where every visit states its side, each
    side is a cycle of its own. Raises InputError for some poses visited only from stated sides
    beside others in the standard's cycle, and for paths as `evaluate_paths`.
    """
    of_path = np.array([bool(path) for path in visits.path])
    loads = []
    for load in sorted(dict.fromkeys(visits.load.tolist()), reverse=True):
        there = visits.load == load
        every = visits.picked(there & ~of_path)
        paths = evaluate_paths(visits.picked(there & of_path), level)
        # What belongs to all sides together stands with the first.
        for k, (side, chosen) in enumerate(_cycles(every)):
            once = {"axes": axis_positionings(every), "paths": paths} if k == 0 else {"paths": ()}
            loads.append(
                MeasuredLoad(
                    load=load, side=side, **once, **_at_poses(chosen, chosen if k else every, level)
                )
            )
    if not any(load.paths or load.pooled is not None for load in loads) and not any(
        math.isfinite(pose.repeatability.value) for load in loads for pose in load.poses
    ):
        _refuse_too_few(visits)
    return MeasuredRobot(visits, tuple(loads))


def _cycles(visits: Visits) -> list[tuple[str, Visits]]:
    """Return the visits as one cycle, or by side where every visit states its side: then each side
    is a cycle.
    """
    sides = dict.fromkeys(visits.side)
    if not visits.pose or "" in sides:
        return [("", visits)]
    each = ((side, visits.picked(np.array([one == side for one in visits.side]))) for side in sides)
    return [(side, replace(found, side=("",) * len(found.pose))) for side, found in each]


def _refuse_too_few(visits: Visits) -> None:
    """Raise InputError for visits that determine neither a repeatability nor an accuracy over
    poses.
    """
    file, line = visits.where[0]
    poses = len(dict.fromkeys(visits.pose))
    found = (
        f"{len(visits.pose)} visit{'s' * (len(visits.pose) > 1)} to {poses} pose{'s' * (poses > 1)}"
    )
    if visits.duplicates:
        found += f", besides {visits.duplicates} duplicate row{'s' * (visits.duplicates > 1)}"
    expected = (
        "at least two visits to a pose (the standard asks for 30), or at least three poses with "
        "commanded positions"
    )
    raise InputError(
        [Problem(file, f"line {line}", found, expected, "cycle 1 to 30, one row for each visit")]
    )


def _at_poses(visits: Visits, every: Visits, level: float) -> dict[str, Any]:
    """Return the fields of a `MeasuredLoad` that belong to poses; `every` holds the visits from all
    sides, for vAP.
    """
    everywhere: dict[str, list[int]] = {}
    for k, name in enumerate(visits.pose):
        everywhere.setdefault(name, []).append(k)
    names = sorted(everywhere, key=natural_order)
    if not names:
        return {"poses": (), "distance": None, "pooled": None, "fit": None, "floor": 0.0}
    rows = {
        name: np.array([k for k in everywhere[name] if not visits.side[k]], dtype=int)
        for name in names
    }
    if alone := [name for name, found in rows.items() if not len(found)]:
        file, line = visits.where[everywhere[alone[0]][0]]
        expected = "visits of the standard's cycle, without a side, at every pose too"
        raise InputError(
            [
                Problem(
                    file,
                    f"line {line}, side",
                    f"a side at all visits to {', '.join(alone)}",
                    expected,
                    "P1,,600.01,0.02,399.98",
                )
            ]
        )
    command = np.array([visits.command[found[0]] for found in rows.values()]).reshape(-1, 3)
    barycentre = np.array([visits.attained[found].mean(axis=0) for found in rows.values()]).reshape(
        -1, 3
    )
    turned = np.array([visits.rotation[found[0]] for found in rows.values()])
    rotation = turned if np.isfinite(turned).all() else None
    fit = (
        best_fit(barycentre, command, rotation)
        if len(rows) >= _FRAME and np.isfinite(command).all()
        else None
    )
    left = np.full(len(rows), math.nan) if fit is None else np.linalg.norm(fit.residual, axis=1)
    turn = visits.turn
    poses = tuple(
        _pose(visits, turn, name, found, float(left[k]), _from_sides(every, name, level), level)
        for k, (name, found) in enumerate(rows.items())
    )
    pooled = None
    if fit is not None:
        raw = barycentre - command
        pooled = (
            _pooled(lambda chosen: raw[chosen], len(raw), level),
            _pooled(_refit(command, rotation, fit), len(raw), level),
        )
    floor = visits.instrument * isotropic_repeatability(min(len(found) for found in rows.values()))
    return {
        "poses": poses,
        "distance": _distance(visits, rows, level),
        "pooled": pooled,
        "fit": fit,
        "floor": floor,
    }


def natural_order(name: str) -> tuple[str, int, str]:
    """Return the sort key that puts P2 before P10."""
    word = name.rstrip("0123456789")
    return word, int(name[len(word) :][-9:] or 0), name


def _pose(
    visits: Visits,
    turn: Floats,
    name: str,
    rows: np.ndarray,
    fitted: float,
    from_sides: Estimate,
    level: float,
) -> MeasuredPose:
    """Return the characteristics of one pose."""
    attained, command = visits.attained[rows], visits.command[rows[0]]
    known = bool(np.isfinite(command).all())
    errors = attained - (command if known else attained.mean(axis=0))
    rotation, turned = visits.rotation[rows[0]], turn[rows]
    with_command = bool(np.isfinite(turned).all())
    if not with_command:
        rotation, turned = _deviations_from_mean(visits.orientation[rows])
    each = np.column_stack([turned, errors])
    measured = [bool(np.isfinite(turned).all())] * 3 + [True] * 3
    commanded = [with_command] * 3 + [known] * 3
    repeat = repeatability_interval(errors, level)
    floor = visits.instrument * isotropic_repeatability(len(rows))
    far = outlying_visits(attained)
    rest = np.delete(errors, list(far), axis=0)
    return MeasuredPose(
        name,
        len(rows),
        command,
        accuracy_interval(errors, level) if known else UNKNOWN,
        repeat,
        tuple(
            student_interval(column, level) if ok else UNKNOWN
            for column, ok in zip(each.T, commanded, strict=True)
        ),
        tuple(
            scatter_interval(column, level) if ok else UNKNOWN
            for column, ok in zip(each.T, measured, strict=True)
        ),
        without_instrument(repeat, floor) if visits.instrument and repeat.value > 0 else UNKNOWN,
        fitted,
        from_sides,
        rotation,
        errors,
        tuple((*visits.where[rows[k]], far[k]) for k in far),
        repeatability_interval(rest, level) if far else UNKNOWN,
        accuracy_interval(rest, level) if far and known else UNKNOWN,
    )


def _deviations_from_mean(orientation: Floats) -> tuple[Floats, Floats]:
    """Return the mean of orientations (visit, 3, 3), and the rotation vectors (visit, 3) from it to
    each; NaN where one is unknown.
    """
    from scipy.spatial.transform import Rotation

    if not np.isfinite(orientation).all():
        return np.full((3, 3), math.nan), np.full((len(orientation), 3), math.nan)
    each = Rotation.from_matrix(orientation)
    middle = each.mean()
    return np.asarray(middle.as_matrix()), np.asarray((each * middle.inv()).as_rotvec())


def _from_sides(visits: Visits, name: str, level: float) -> Estimate:
    """Return vAP_p, with the interval of the two sides whose barycentres are farthest apart."""
    sides: dict[str, list[int]] = {}
    for k, pose in enumerate(visits.pose):
        if pose == name and visits.side[k]:
            sides.setdefault(visits.side[k], []).append(k)
    sets = [visits.attained[found] for found in sides.values()]
    if len(sets) < MIN_VISITS:
        return UNKNOWN
    pairs = [(one, other) for one, other in itertools.combinations(sets, 2)]
    one, other = max(
        pairs, key=lambda pair: float(np.linalg.norm(pair[0].mean(axis=0) - pair[1].mean(axis=0)))
    )
    between, fewest = one.mean(axis=0) - other.mean(axis=0), min(len(one), len(other))
    if fewest < MIN_VISITS:
        return Estimate(float(np.linalg.norm(between)), math.nan, math.nan)
    return length_interval(
        between, np.cov(one.T) / len(one) + np.cov(other.T) / len(other), fewest - 1, level
    )


def _distance(
    visits: Visits, rows: dict[str, np.ndarray], level: float
) -> tuple[Estimate, Estimate] | None:
    """Return AD_p and RD between P2 and P4, from the cycles that visited both; None without two of
    them.
    """
    if not {"P2", "P4"} <= set(rows):
        return None
    cycles = [
        dict(zip(visits.cycle[rows[name]].tolist(), rows[name].tolist(), strict=True))
        for name in ("P2", "P4")
    ]
    both = sorted(set(cycles[0]) & set(cycles[1]))
    if len(both) < MIN_VISITS:
        return None
    ends = [visits.attained[[at[cycle] for cycle in both]] for at in cycles]
    far = np.linalg.norm(ends[1] - ends[0], axis=1)
    command = float(np.linalg.norm(visits.command[rows["P4"][0]] - visits.command[rows["P2"][0]]))
    return (
        student_interval(far - command, level) if math.isfinite(command) else UNKNOWN
    ), scatter_interval(far, level)


def _refit(
    command: Floats, rotation: Floats | None, fit: Fit
) -> Callable[[np.ndarray], np.ndarray]:
    """Return the function from poses to their residuals after their own best fit, by small steps
    about the fit over all poses.
    """
    stands = (command if rotation is None else command + rotation @ fit.tool) @ fit.base[
        :3, :3
    ].T + fit.base[:3, 3]
    turned = None if rotation is None else fit.base[:3, :3] @ rotation

    def left(chosen: np.ndarray) -> np.ndarray:
        return residual_after_fit(
            fit.residual[chosen], stands[chosen], None if turned is None else turned[chosen]
        )

    return left


def _pooled(
    left: Callable[[np.ndarray], np.ndarray], count: int, level: float
) -> tuple[Estimate, ...]:
    """Return mean, standard deviation, 95th percentile and maximum of the lengths of residuals,
    with bootstrap intervals over poses.
    """

    def statistics(chosen: np.ndarray) -> Floats:
        lengths = np.linalg.norm(left(chosen), axis=1)
        return np.array(
            [lengths.mean(), lengths.std(ddof=1), np.quantile(lengths, 0.95), lengths.max()]
        )

    low, high = np.full((2, 4), math.nan)
    if count >= _MIN_POSES:
        rng = generator("poses")
        resampled = np.array(
            [statistics(rng.integers(count, size=count)) for _ in range(_RESAMPLES)]
        )
        low[:3], high[:3] = np.quantile(
            resampled[:, :3], [(1 - level) / 2, (1 + level) / 2], axis=0
        )
    return tuple(
        Estimate(float(value), float(a), float(b))
        for value, a, b in zip(statistics(np.arange(count)), low, high, strict=True)
    )
