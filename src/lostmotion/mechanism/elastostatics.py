"""How much does the whole arm give? Links, joint units and base as springs, carried to the tool: compliance, deflection, ellipsoids, shares.

One truth: nothing here knows how a part gives way. Each part is asked for its terms under wrenches a little off its own load, and the difference is
its compliance there. What of a part's answer rests within a play ("seated" terms) is no spring and left out: all here holds while plays stay closed.
A gearbox within the loop of an encoder on its output is held by the controller and does not give.

Directions are (rotation, displacement) of the tool and (moment, force) at the tool point, both in the base's axes. First order: the pose that the
unloaded arm stands in. C = sum of J C_part J^T over the parts; for the drives alone: J. Salisbury, Active stiffness control of a manipulator in
cartesian coordinates, Proc. 19th IEEE Conf. on Decision and Control, 1980.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.carry import carry
from lostmotion.mechanism.serial import as_poses, conditions, frames

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.error_source import Condition, ErrorSource
    from lostmotion.spatial import Floats

# Poses at a time: what parts work on then stays in the processor's cache.
_BLOCK: Final = 1024
# The change of wrench, as a share of the whole load at the part: small against zones of stiffness, large against rounding.
_STEP: Final = 1e-3
# Makes one size of forces and moments, m: about what lies between the bearings of a joint.
_LEVER: Final = 0.1
# A part that carries less than this (N) counts as carrying it: without load a contact has no stiffness at all.
_LEAST: Final = 1.0
# Both differences of a spring in proportion agree to rounding, which the steps' smallness makes 1e-13 of them.
_SAME: Final = 1e-9
_LIKE_NO_OTHER: Final = np.array([0.713, -0.541, 0.389, 0.617, 0.853, -0.467])
# Below this share of the largest, a direction counts as rigid: what differences leave of zero is a thousandth of it.
_RIGID: Final = 1e-10


@dataclass(frozen=True, repr=False)
class Compliances:
    """Compliance at the tool by elastic part: `by_part` (part, pose, 6, 6) in rad, m per N m, N; `tool` (pose, 3) the tool point, m."""

    parts: tuple[str, ...]
    by_part: Floats
    tool: Floats

    @property
    def whole(self) -> Floats:
        """Return the compliance of the whole arm (pose, 6, 6)."""
        return np.asarray(self.by_part.sum(axis=0))

    @property
    def mean_compliance(self) -> Floats:
        """Return by part (part, pose) the displacement along a force per newton, averaged over all directions of the force, m/N."""
        return np.asarray(np.einsum("tpii->tp", self.by_part[:, :, 3:, 3:])) / 3

    @property
    def shares(self) -> Floats:
        """Return each part's share (part, pose) of `mean_compliance`; NaN at poses where every part is rigid."""
        own = self.mean_compliance
        with np.errstate(invalid="ignore"):
            return np.asarray(own / own.sum(axis=0))

    @property
    def asymmetry(self) -> Floats:
        """Return the departure of the displacement under a force from reciprocity (pose,), as a share of the largest; NaN where every part is rigid.

        Rounding only, except with bearings described by drawings: there it is the uncertainty of the slopes of their tables.
        """
        shift = self.whole[:, 3:, 3:]
        off = np.abs(shift - shift.transpose(0, 2, 1)).max(axis=(1, 2), initial=0.0)
        with np.errstate(invalid="ignore"):
            return np.asarray(off / np.abs(shift).max(axis=(1, 2), initial=0.0))


def compliances(arm: Arm, q: Floats) -> Compliances:
    """How much does each part let the tool give at these poses, q (pose, joint) in rad or m?

    The tangent at what the part carries there, by a symmetric difference over ±0.1 % of its load, and of 1 N where it carries less: exact for
    springs in proportion, and for stiffness zones away from their ends; a contact between rolling elements without load gives without bound, here
    as much as at a millinewton. Raises ValueError for q of another shape or not finite.
    """
    values = as_poses(arm, q)
    first = _first_tangents(arm, values[:1])
    owners = tuple(dict.fromkeys(owner for owner, _ in first.values()))
    by_part = np.zeros((len(owners), len(values), 6, 6))
    tool = np.empty((len(values), 3))
    for start in range(0, len(values), _BLOCK):
        here = slice(start, start + _BLOCK)
        at = frames(arm, values[here])
        tool[here] = at[-1, :, :3, 3]
        carries: dict[int, Floats] = {}
        for number, (_, place, source, felt) in enumerate(conditions(arm, values[here], at)):
            if number in first:
                owner, known = first[number]
                if place not in carries:
                    carries[place] = carry(arm.tree, at, place)
                by_part[owners.index(owner), here] += carries[place] @ _tangents(source, felt, known) @ carries[place].transpose(0, 2, 1)
    return Compliances(owners, by_part, tool)


def compliance(arm: Arm, q: Floats) -> Floats:
    """Return the twist of the tool per wrench on it (pose, 6, 6), rad and m per N m and N; arguments and errors as `compliances`.

    Symmetric and positive semidefinite, as long as the parts' own laws are (reciprocity).
    """
    return compliances(arm, q).whole


def stiffness(arm: Arm, q: Floats) -> Floats:
    """Return the stiffness of the tool (pose, 6, 6), N m and N per rad and m, the inverse of `compliance`; arguments and errors as there.

    NaN at poses where some direction is rigid.
    """
    return _inverse(compliance(arm, q))


def deflection(arm: Arm, q: Floats, wrench: Floats) -> Floats:
    """How far does the tool turn and shift (pose, 6; rad, m) if this wrench comes to what the arm carries already?

    wrench (6,) or (pose, 6): moment and force at the tool point in the base's axes, N m and N. Not the tangent: parts are asked with and without the
    wrench, so that zones and contacts count over the whole way; for springs in proportion it is compliance @ wrench. A rigid arm: zero.
    Raises ValueError for q or wrench of another shape or not finite.
    """
    values = as_poses(arm, q)
    load = np.asarray(wrench, dtype=float)
    if load.shape not in {(6,), (len(values), 6)} or not np.isfinite(load).all():
        raise ValueError(f"a wrench of shape {load.shape}; expected 6 finite values, moment and force, or as many per pose")
    load = np.broadcast_to(load, (len(values), 6))
    out = np.zeros((len(values), 6))
    for start in range(0, len(values), _BLOCK):
        here = slice(start, start + _BLOCK)
        at = frames(arm, values[here])
        for _, place, source, felt in conditions(arm, values[here], at):
            carried = carry(arm.tree, at, place)
            more = replace(felt, wrench=felt.wrench + np.einsum("pji,pj->pi", carried, load[here]))
            after, before = given(source, more), given(source, felt)
            if after is not None and before is not None:
                out[here] += np.einsum("pij,pj->pi", carried, after - before)
    return out


def given(source: ErrorSource, felt: Condition) -> Floats | None:
    """By which twist (pose, 6) in its own frame does a part give way here, play not counted? None for a part that has no springs."""
    out: Floats | None = None
    for term in source.terms(felt):
        if term.level == "design" and not term.seated:
            out = term.screw if out is None else out + term.screw
    return None if out is None else np.broadcast_to(out, felt.wrench.shape)


def _first_tangents(arm: Arm, q: Floats) -> dict[int, tuple[str, Floats]]:
    """Which parts, by their number in walking order, have springs, who owns them, and what is their compliance (6, 6) at the first pose?"""
    out = {}
    for number, (owner, _, source, felt) in enumerate(conditions(arm, q, frames(arm, q))):
        if given(source, felt) is not None:
            out[number] = owner, _tangents(source, felt, None)[0]
    return out


@dataclass(frozen=True)
class Ellipsoid:
    """Principal directions (pose, 3, 3), in columns, and the compliance along them (pose, 3) in m/N (or rad/(N m)), the softest first.

    A unit force along a principal direction moves the tool point along it and nowhere else.
    """

    directions: Floats
    values: Floats


def ellipsoid(matrix: Floats, *, rotation_held: bool = False) -> Ellipsoid:
    """Return the principal directions of the tool point's displacement under a force, for compliances (pose, 6, 6).

    The tool is free to rotate, or its rotation is constrained (`rotation_held`: the inverse of the stiffness's translational block). For a rigid arm
    all values are zero, and the directions are arbitrary.
    """
    shift = matrix[..., 3:, 3:]
    if rotation_held:
        turns = matrix[..., :3, :3]
        shift = shift - matrix[..., 3:, :3] @ np.linalg.pinv(turns, rcond=_RIGID, hermitian=True) @ matrix[..., :3, 3:]
    values, directions = np.linalg.eigh((shift + np.swapaxes(shift, -1, -2)) / 2)
    return Ellipsoid(directions[..., ::-1], np.maximum(values[..., ::-1], 0.0))


def _inverse(matrix: Floats) -> Floats:
    """Return the inverse (pose, 6, 6), NaN where some direction is rigid."""
    out = np.full_like(matrix, np.nan)
    turn, shift = (np.sqrt(np.einsum("pii->p", matrix[:, each, each])) for each in (slice(3), slice(3, 6)))
    some = np.flatnonzero((turn > 0) & (shift > 0))
    # Rotations and displacements in units in which both are of one size.
    unit = np.repeat(np.stack([turn[some], shift[some]], axis=1), 3, axis=1)
    unit = unit[:, :, None] * unit[:, None, :]
    alike = matrix[some] / unit
    firm = np.linalg.eigvalsh(alike)[:, 0] > _RIGID
    out[some[firm]] = np.linalg.inv(alike[firm]) / unit[firm]
    return out


def _tangents(source: ErrorSource, felt: Condition, known: Floats | None) -> Floats:
    """How does a part's twist follow the wrench on it (pose, 6, 6), both in the part's frame?

    `known` (6, 6): what it was at some other pose. Most parts give in proportion: along one direction that is like no other each pose is asked
    whether it is the same there, and in full only where it is not.
    """
    poses = len(felt.wrench)
    step = _steps(felt)
    if known is None:
        return _in_full(source, felt, step)
    out = np.broadcast_to(known, (poses, 6, 6))
    along = (step * _LIKE_NO_OTHER)[:, None, :]
    seen = _differences(source, felt, along)[:, :, 0]
    expected = 2 * along[:, 0] @ known.T
    differs = np.linalg.norm(seen - expected, axis=1) > _SAME * np.linalg.norm(expected, axis=1)
    if differs.any():
        out = out.copy()
        out[differs] = _in_full(source, _rows(felt, differs), step[differs])
    return out


def _in_full(source: ErrorSource, felt: Condition, step: Floats) -> Floats:
    return _differences(source, felt, step[:, :, None] * np.eye(6)) / (2 * step[:, None, :])


def _steps(felt: Condition) -> Floats:
    """By how much to change each component of the wrench (pose, 6), N m and N?"""
    force, moment = np.linalg.norm(felt.wrench[:, 3:], axis=1), np.linalg.norm(felt.wrench[:, :3], axis=1)
    out = np.empty((len(force), 6))
    out[:, 3:] = _STEP * np.maximum(force + moment / _LEVER, _LEAST)[:, None]
    out[:, :3] = _LEVER * out[:, 3:]
    return out


def _differences(source: ErrorSource, felt: Condition, changes: Floats) -> Floats:
    """By how much does a part's twist differ (pose, 6, change) between its wrench with and less each of these changes (pose, change, 6)?"""
    poses, count = changes.shape[:2]
    wrench = felt.wrench[:, None, None, :] + changes[:, :, None, :] * np.array([[1.0], [-1.0]])
    # All wrenches of all poses in one evaluation.
    every = _rows(felt, np.repeat(np.arange(poses), 2 * count))
    moved = given(source, replace(every, wrench=wrench.reshape(-1, 6)))
    if moved is None:
        return np.zeros((poses, 6, count))
    pairs = moved.reshape(poses, count, 2, 6)
    return np.asarray((pairs[:, :, 0] - pairs[:, :, 1]).transpose(0, 2, 1))


def _rows(felt: Condition, chosen: np.ndarray) -> Condition:
    return replace(felt, angle=felt.angle[chosen], wrench=felt.wrench[chosen], gravity=felt.gravity[chosen], approach=felt.approach[chosen])
