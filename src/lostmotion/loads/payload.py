"""The largest payload of an arm at rest: by the rated torques of its drives, by its sag, and by its
accuracy.

Each limit holds by itself, at every pose. Drives: the size of a holding torque is a convex function
of the payload's mass, at any tilt of the base, so there is one mass at which it reaches the rated
torque; it is found by halving its range. Sag: the displacement of the tool by the arm's own weight
and the payload's, from the deflections of all springs; in closed form for linear ones, else by
halving too; of a soft arm where it stands, found as for the accuracy. Accuracy: the error that 95 %
of the positions at a pose stay within, over robots and visits, computed for a row of masses and
interpolated between them; at the pose with the smallest payload it is solved for.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.error_model.overload import rated_torques
from lostmotion.mechanism.assembly import may_not_assemble
from lostmotion.mechanism.elastostatics import sagging_terms
from lostmotion.mechanism.equilibrium import settle
from lostmotion.mechanism.state import DesignDeflection, state_of, tool_points
from lostmotion.mechanism.tool import Payload
from lostmotion.spatial import cross

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

Criterion = Literal["drives", "sag", "accuracy"]
# kg; a payload that no arm holds counts as no limit.
MOST: Final = 1e5
# Poses at which the accuracy is evaluated, and masses between which it is interpolated.
ACCURACY_POSES: Final = 128
_MASSES: Final = 16
_LEVEL: Final = 0.95
# Relative change of a torque that is rounding, and relative precision of a mass.
_ROUNDING: Final = 1e-9
_PRECISION: Final = 1e-6
_STEPS: Final = 30


@dataclass(frozen=True)
class PayloadLimit:
    """The largest payload by one criterion.

    q       (pose, joint) rad or m, the poses that it was found at
    tool    (pose, 3) m
    values  (pose,) kg; infinite where the criterion allows more than any arm holds, zero where it
            is not met without payload
    empty   (pose,) whether the criterion is not met without payload
    joints  (pose,) index of the moving joint that governs; empty for criteria other than the drives
    limit   m, of sag or accuracy; None for the drives
    """

    criterion: Criterion
    q: Floats
    tool: Floats
    values: Floats
    empty: NDArray[np.bool_]
    joints: NDArray[np.int64]
    limit: float | None = None

    @property
    def worst(self) -> int:
        """Return the index of the pose with the smallest payload."""
        return int(self.values.argmin())

    @property
    def everywhere(self) -> float:
        """Return the largest payload (kg) that meets the criterion at every one of the poses."""
        return float(self.values[self.worst])


@dataclass(frozen=True)
class MaxPayload:
    """The largest payload by each criterion that was asked for, and the moving joints that are
    loaded by it and state no rated torque.

    tilt  rad, largest tilt of the base for the drives; None: as the base stands
    """

    limits: tuple[PayloadLimit, ...]
    unrated: tuple[str, ...]
    tilt: float | None = None

    @property
    def governing(self) -> PayloadLimit | None:
        """Return the limit with the smallest payload; None where none limits it."""
        finite = [each for each in self.limits if math.isfinite(each.everywhere)]
        return min(finite, key=lambda each: each.everywhere) if finite else None


def max_payload(
    arm: Arm,
    poses: Poses,
    tilt: float | None,
    sag_limit: float | None,
    accuracy_limit: float | None,
) -> MaxPayload:
    """Return the largest payload at these poses by the drives, and by sag and accuracy (m) where
    limits are stated.

    The payload has its centre of mass and its process force as the arm states them; the sag is that
    of the weights alone. Static: without acceleration. The drives count at the nominal base, or
    within `tilt` (rad). The mass of the tool stays. At poses that are not among these the arm may
    hold less.
    """
    q = poses.q
    drives, unrated = _by_drives(arm, q, tilt)
    out = [drives]
    if sag_limit is not None:
        out.append(_by_sag(arm, q, sag_limit))
    if accuracy_limit is not None:
        chosen = (
            q
            if len(q) <= ACCURACY_POSES
            else q[np.linspace(0, len(q) - 1, ACCURACY_POSES).astype(int)]
        )
        out.append(_by_accuracy(arm, chosen, accuracy_limit))
    return MaxPayload(tuple(out), unrated, tilt)


def _with_mass(arm: Arm, mass: float) -> Arm:
    return arm.with_payload(arm.payload.model_copy(update={"mass": mass}))


def _by_drives(arm: Arm, q: Floats, tilt: float | None) -> tuple[PayloadLimit, tuple[str, ...]]:
    """Return the limit by the drives' rated torques, and the joints that the payload loads and that
    state none.
    """
    rated, held = rated_torques(arm), _loads_of_drives(arm, q, tilt)
    alone = np.zeros((len(q), len(rated)))
    of_payload = np.abs(held(alone + MOST)).max(axis=0) > _ROUNDING * MOST
    unrated = tuple(
        joint.name
        for joint, loads, limit in zip(arm.driven, of_payload, rated, strict=True)
        if loads and np.isnan(limit)
    )
    values = _bisected(held, np.where(np.isnan(rated), math.inf, rated), alone.shape)
    over = np.asarray(held(alone) > rated * (1 + _ROUNDING))
    values[over] = 0.0
    return PayloadLimit(
        "drives",
        q,
        tool_points(arm, q),
        values.min(axis=1),
        np.asarray(over.any(axis=1)),
        values.argmin(axis=1),
    ), unrated


def _loads_of_drives(arm: Arm, q: Floats, tilt: float | None) -> Callable[[Floats], Floats]:
    """Return the size of the drives' loads (pose, joint), N m or N, as a function of a payload
    (pose, joint; kg) for each of them.

    Loads are linear in gravity and in the payload's mass. As the base stands gravity is one vector;
    with a tilt it is any within a cone, of which the worst is nearest to the gradient
    (`worst_torques_over_tilts`).
    """
    bare, loaded = _with_mass(arm, 0.0), _with_mass(arm, 1.0)
    states = [state_of(each, q) for each in (bare, loaded)]
    if tilt is None:
        own, full = (state.torques for state in states)
        per_mass = full - own
        return lambda masses: np.abs(own + masses * per_mass)
    process = replace(states[0], gravity=np.zeros(3)).torques
    axes = arm.gravity * np.eye(3)
    own, full = (
        np.stack([replace(state, gravity=axis).torques - process for axis in axes], axis=-1)
        for state in states
    )

    def held(masses: Floats) -> Floats:
        along = own + masses[..., None] * (full - own)
        from_down = np.arctan2(np.hypot(along[..., 0], along[..., 1]), -along[..., 2])
        size = np.linalg.norm(along, axis=-1)
        most, least = (
            size * np.cos(np.maximum(angle - tilt, 0.0))
            for angle in (from_down, math.pi - from_down)
        )
        return np.asarray(np.maximum(np.abs(process + most), np.abs(process - least)))

    return held


def _by_sag(arm: Arm, q: Floats, limit: float) -> PayloadLimit:
    """Return the limit by the displacement of the tool due to its own weight and the payload's, m:
    of a soft open arm where it stands, of any other of first order; without what servos feed
    forward.
    """
    bare = arm.with_payload(Payload(centre_of_mass=arm.payload.centre_of_mass))
    if arm.soft_freedoms and not may_not_assemble(arm):
        return _by_values("sag", bare, q, limit, functools.partial(_droops, bare))
    if any("weight" in each.term.form.reads for each in sagging_terms(arm)):  # fed forward
        return _by_values("sag", bare, q, limit, functools.partial(_sags, bare))
    state = state_of(bare, q)
    at = state.frames[-1]
    weight = np.broadcast_to(arm.gravity_in_base, (len(q), 3))
    per_mass = np.hstack(
        [cross(at[:, :3, :3] @ np.array(arm.payload.centre_of_mass), weight), weight]
    )
    own = state.sag[:, 3:]

    def sagging(masses: Floats) -> Floats:
        return np.asarray(
            np.linalg.norm(own + state.deflection(masses[:, None] * per_mass)[:, 3:], axis=1)
        )

    empty = np.linalg.norm(own, axis=1) > limit * (1 + _ROUNDING)
    slope = state.deflection(per_mass)[:, 3:]
    values = np.where(empty, 0.0, _root(own, slope, limit))
    found = np.where(np.isfinite(values), values, 0.0)
    if (
        np.abs(sagging(found) - limit)[np.isfinite(values) & ~empty].max(initial=0.0)
        > _PRECISION * limit
    ):
        values = np.where(empty, 0.0, _bisected(sagging, limit, (len(q),)))
    return PayloadLimit("sag", q, at[:, :3, 3], values, empty, np.zeros(0, dtype=int), limit)


def _droops(bare: Arm, mass: float, q: Floats) -> Floats:
    """Return how far the tool of the arm with a payload of this mass sags (pose,), m, where it
    stands: by the terms of `State.sag`; infinite where the arm cannot hold it.
    """
    state = state_of(_with_mass(bare, mass), q)
    found = settle(bare.tree, state.frames, DesignDeflection(state, sagging_terms(state.arm)))
    away = found.frames[-1, :, :3, 3] - found.command[-1, :, :3, 3]
    return np.asarray(np.nan_to_num(np.linalg.norm(away, axis=1), nan=math.inf))


def _sags(bare: Arm, mass: float, q: Floats) -> Floats:
    """Return how far the tool of the arm with a payload of this mass sags (pose,), m, to first
    order.
    """
    return np.asarray(np.linalg.norm(state_of(_with_mass(bare, mass), q).sag[:, 3:], axis=1))


def _root(own: Floats, slope: Floats, limit: float) -> Floats:
    """Return the mass (pose,) at which |own + mass slope| reaches the limit; infinite where it does
    not.
    """
    square, half, rest = (
        (slope**2).sum(axis=1),
        (own * slope).sum(axis=1),
        (own**2).sum(axis=1) - limit**2,
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        mass = (-half + np.sqrt(np.maximum(half**2 - square * rest, 0.0))) / square
    return np.where(square * MOST**2 > limit**2, mass, math.inf)


def _bisected(
    of_mass: Callable[[Floats], Floats], limit: Floats | float, shape: tuple[int, ...]
) -> Floats:
    """Return the masses, kg, at which values that grow with them reach the limit; infinite where
    none below `MOST` does.
    """
    low, high = np.zeros(shape), np.ones(shape)
    while (short := (of_mass(high) <= limit) & (high < MOST)).any():
        low, high = np.where(short, high, low), np.where(short, 2 * high, high)
    open_end = of_mass(high) <= limit
    for _ in range(_STEPS):
        middle = (low + high) / 2
        fits = of_mass(middle) <= limit
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    return np.where(open_end, math.inf, low)


def _by_accuracy(arm: Arm, q: Floats, limit: float) -> PayloadLimit:
    """Return the limit by the error (m) that 95 % of the positions at a pose stay within."""
    from lostmotion.error_model.pose_matrix import pose_matrix
    from lostmotion.propagation.analytic import DrawnColumns, of_screws

    drawn = DrawnColumns(pose_matrix(arm, q))

    def within(mass: float, at: Floats) -> Floats:
        return np.asarray(
            of_screws(
                pose_matrix(_with_mass(arm, mass), at), drawn, (_LEVEL,), with_bounds=False
            ).quantiles[:, 0]
        )

    return _by_values("accuracy", arm, q, limit, within)


def _by_values(
    criterion: Criterion,
    arm: Arm,
    q: Floats,
    limit: float,
    within: Callable[[float, Floats], Floats],
) -> PayloadLimit:
    """Return the limit by values (m) that grow with the payload, as a function of its mass and the
    poses: computed for a row of masses and interpolated between them, and solved at the worst pose.
    """
    error = within(0.0, q)
    empty = error > limit
    if empty.all():
        return PayloadLimit(
            criterion,
            q,
            tool_points(arm, q),
            np.zeros(len(q)),
            empty,
            np.zeros(0, dtype=int),
            limit,
        )
    masses, errors, high = [0.0], [error], max(arm.payload.mass, 1.0)
    while (errors[-1] <= limit).any() and high < MOST:
        masses, errors, high = [*masses, high], [*errors, within(high, q)], 2 * high
    first = max(
        (mass for mass, each in zip(masses, errors, strict=True) if (each[~empty] <= limit).all()),
        default=0.0,
    )
    for mass in np.linspace(first, masses[-1], _MASSES)[1:-1].tolist():
        masses, errors = [*masses, mass], [*errors, within(mass, q)]
    order = np.argsort(masses)
    values = np.where(
        empty, 0.0, _crossing(np.array(masses)[order], np.array(errors)[order], limit)
    )
    out = PayloadLimit(
        criterion, q, tool_points(arm, q), values, empty, np.zeros(0, dtype=int), limit
    )
    if 0 < out.everywhere < math.inf:
        values[out.worst] = _solved(
            lambda mass: float(within(mass, q[out.worst][None])[0]) - limit, out.everywhere
        )
    return out


def _crossing(masses: Floats, errors: Floats, limit: float) -> Floats:
    """Return the mass (pose,) at which errors (mass, pose) first exceed the limit, between masses
    by interpolation; infinite where none does.
    """
    beyond = errors > limit
    k = np.maximum(beyond.argmax(axis=0), 1)
    pose = np.arange(errors.shape[1])
    low, high = errors[k - 1, pose], errors[k, pose]
    with np.errstate(divide="ignore", invalid="ignore"):
        found = masses[k - 1] + (masses[k] - masses[k - 1]) * np.clip(
            (limit - low) / (high - low), 0.0, 1.0
        )
    return np.where(beyond.any(axis=0), found, math.inf)


def _solved(excess: Callable[[float], float], near: float) -> float:
    """Return the mass at which the excess over a limit is zero, from a value near it."""
    from scipy.optimize import brentq

    low, high = 0.9 * near, 1.1 * near
    while excess(low) > 0:
        low *= 0.5
    while excess(high) <= 0:
        high *= 1.5
    return float(brentq(excess, low, high, rtol=1e-4))
