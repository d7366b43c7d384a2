"""How much does one link bend, for any section that it might have? Its loads worked out once; then each section is a small matrix."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Self

import numpy as np

from lostmotion.mechanism.holding_torques import direction_within
from lostmotion.mechanism.serial import frames, wrenches

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.link import ElasticLink
    from lostmotion.spatial import Floats

_BLOCK: Final = 4096
# Directions across a link that are tried, and then so many between the neighbours of the best: within 1e-5 of the largest.
_COARSE: Final = 48
_FINE: Final = 33


@dataclass(frozen=True, slots=True)
class Worst:
    """What one link does at worst over poses, and over tilts of the base: slope (rad), deflection (m) and the indices of the poses where."""

    slope: float
    slope_index: int
    deflection: float
    deflection_index: int


@dataclass(frozen=True)
class LinkLoads:
    """What acts on one link, at every pose: (pose, 9), the wrench on its tip and gravity there, both in the tip's axes.

    standing    (pose, 9) as the base stands
    fixed       (pose, 9) without gravity: the process force; None without a tilt
    by_gravity  (pose, 9, 3) per m/s^2 of gravity along each axis of the base; None without a tilt
    gravity     (3,) m/s^2 in the base's axes, as the base stands
    tilt        rad: gravity may lie anywhere within so much of the base's own downward axis; None: only where it is

    The link's own section is in none of it.
    """

    standing: Floats
    fixed: Floats | None
    by_gravity: Floats | None
    gravity: Floats
    tilt: float | None

    @classmethod
    def of(cls, arm: Arm, joint: int, q: Floats, tilt: float | None) -> Self:
        """Which loads does everything outboard put on the link behind the joint number `joint` of `arm.joints`?"""
        blocks = [q[start : start + _BLOCK] for start in range(0, len(q), _BLOCK)]
        tip, now = arm.tree.joints[joint].tip, arm.gravity_in_base
        standing = np.concatenate([_load(arm, tip, block, now) for block in blocks])
        if tilt is None:
            return cls(standing, None, None, now, None)
        fixed = np.concatenate([_load(arm, tip, block, np.zeros(3)) for block in blocks])
        by_axis = [np.concatenate([_load(arm, tip, block, axis) for block in blocks]) - fixed for axis in np.eye(3)]
        return cls(standing, fixed, np.stack(by_axis, axis=-1), now, tilt)

    def at(self, poses: np.ndarray) -> LinkLoads:
        """Give the loads at some of the poses only."""
        fixed, by_gravity = (None if each is None else each[poses] for each in (self.fixed, self.by_gravity))
        return replace(self, standing=self.standing[poses], fixed=fixed, by_gravity=by_gravity)

    def felt(self, pose: int, gravity: Floats) -> Floats:
        """Give what acts at one pose (9,) under this gravity, which is that of the base as it stands unless there is a tilt."""
        if self.fixed is None or self.by_gravity is None:
            return np.asarray(self.standing[pose])
        return np.asarray(self.fixed[pose] + self.by_gravity[pose] @ gravity)

    def bent(self, link: ElasticLink) -> Floats:
        """By how much does this link bend (pose, 2): slope (rad) and deflection (m) of its tip against the joint, across it, at worst over tilts?

        As `causes.bending`: without what lies along the link. Over tilts exact to 1e-5: the bending follows gravity linearly, so the furthest it
        goes in one direction is known without search, and that direction is searched.
        """
        give = _give(link)
        if self.fixed is None or self.by_gravity is None or self.tilt is None:
            whole = (self.standing @ give.T).reshape(-1, 2, 2)
            return np.asarray(np.sqrt(np.einsum("pma,pma->pm", whole, whole)))
        fixed, by_gravity = self.fixed @ give.T, np.einsum("ab,pbi->pai", give, self.by_gravity) * float(np.linalg.norm(self.gravity))
        return np.column_stack([_furthest(fixed[:, rows], by_gravity[:, rows], self.tilt) for rows in (slice(0, 2), slice(2, 4))])

    def worst(self, link: ElasticLink) -> Worst:
        """What does this link do at worst?"""
        bent = self.bent(link)
        slope, deflection = (int(each) for each in bent.argmax(axis=0))
        return Worst(float(bent[slope, 0]), slope, float(bent[deflection, 1]), deflection)

    def worst_gravity(self, link: ElasticLink, pose: int, measure: int) -> Floats:
        """Under which gravity (3,), within the tilt, does this link bend most at a pose? measure 0: slope, 1: deflection."""
        if self.tilt is None or self.fixed is None or self.by_gravity is None:
            return self.gravity
        size = float(np.linalg.norm(self.gravity))
        rows = _give(link)[2 * measure : 2 * measure + 2]
        fixed, slopes = rows @ self.fixed[pose], rows @ self.by_gravity[pose]
        angles = np.linspace(0, 2 * math.pi, _COARSE * _FINE)
        towards = np.column_stack([np.cos(angles), np.sin(angles)])
        best = int(_support(fixed[None], size * slopes[None], towards[None], self.tilt).argmax())
        return size * direction_within(towards[best] @ slopes, self.tilt)


def bending_under(link: ElasticLink, felt: Floats, measure: int) -> Floats:
    """By how much does a link bend (2,), its two components across it, under what acts on it (9,)? measure 0: slope, 1: deflection."""
    return np.asarray(_give(link)[2 * measure : 2 * measure + 2] @ felt)


def _load(arm: Arm, tip: int, q: Floats, gravity: Floats) -> Floats:
    return np.hstack([wrenches(arm, q, gravity=gravity)[tip], gravity @ frames(arm, q)[tip, :, :3, :3]])


def across(link: ElasticLink) -> Floats:
    """Which matrix (2, 3) gives a vector's two components across a link, from the tip's axes?"""
    along = link.tip_from_joint @ link.link.tip_pose[:3, 3] / link.link.reach
    first = np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(along, first)])


def _give(link: ElasticLink) -> Floats:
    """Which matrix (4, 9) gives slope (2) and deflection (2) across the link from the wrench on its tip and gravity there?"""
    return np.asarray(np.kron(np.eye(2), across(link)) @ np.hstack([link.tip_compliance, link.own_weight_compliance]))


def _furthest(fixed: Floats, by_gravity: Floats, tilt: float) -> Floats:
    """How far from zero does fixed (pose, 2) + by_gravity (pose, 2, 3) @ d come (pose,), over unit directions d within `tilt` of straight down?"""
    angles = np.arange(_COARSE) * (2 * math.pi / _COARSE)
    best = np.zeros(len(fixed))
    for count, width in ((_COARSE, 0.0), (_FINE, 2 * math.pi / _COARSE)):
        tried = np.broadcast_to(angles, (len(fixed), count)) if not width else best[:, None] + np.linspace(-width, width, count)
        towards = np.stack([np.cos(tried), np.sin(tried)], axis=-1)
        reach = _support(fixed, by_gravity, towards, tilt)
        best = np.take_along_axis(tried, reach.argmax(axis=1)[:, None], axis=1)[:, 0]
    return np.asarray(reach.max(axis=1))


def _support(fixed: Floats, by_gravity: Floats, towards: Floats, tilt: float) -> Floats:
    """How far does the bending go in each of these directions across the link (pose, direction, 2), at most over tilts? (pose, direction)."""
    wanted = np.einsum("pka,pai->pki", towards, by_gravity)
    away = np.arctan2(np.hypot(wanted[..., 0], wanted[..., 1]), -wanted[..., 2])
    size = np.sqrt(np.einsum("pki,pki->pk", wanted, wanted))
    return np.asarray(np.einsum("pka,pa->pk", towards, fixed) + size * np.cos(np.maximum(away - tilt, 0.0)))
