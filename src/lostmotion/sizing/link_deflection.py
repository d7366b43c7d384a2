"""Slope and deflection of one link for any section: its loads are computed once, each section is
then a small matrix.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Self

import numpy as np

from lostmotion.mechanism.holding_torques import direction_within
from lostmotion.mechanism.state import state_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.elastic_link import ElasticLink
    from lostmotion.spatial import Floats

_BLOCK: Final = 4096
# Directions across a link, and directions between the neighbours of the best: within 1e-5 of the
# largest.
_COARSE: Final = 48
_FINE: Final = 33


@dataclass(frozen=True, slots=True)
class WorstDeflection:
    """Largest slope (rad) and deflection (m) of one link over poses and tilts of the base, with the
    indices of their poses.
    """

    slope: float
    slope_index: int
    deflection: float
    deflection_index: int


@dataclass(frozen=True)
class LinkLoads:
    """Loads of one link at every pose (pose, 9): the wrench on its tip, and gravity, both in the
    tip's axes. Independent of the link's section.

    nominal     (pose, 9) with the base as stated
    fixed       (pose, 9) without gravity: the process force; None without a tilt
    by_gravity  (pose, 9, 3) per m/s^2 of gravity along each axis of the base; None without a tilt
    gravity     (3,) m/s^2 in the base's axes, with the base as stated
    tilt        rad, largest angle of gravity from the base's downward axis; None: gravity as stated
    """

    nominal: Floats
    fixed: Floats | None
    by_gravity: Floats | None
    gravity: Floats
    tilt: float | None

    @classmethod
    def of(cls, arm: Arm, joint: int, q: Floats, tilt: float | None) -> Self:
        """Return the loads on the link of the joint number `joint` of `arm.joints` by everything
        outboard.
        """
        blocks = [q[start : start + _BLOCK] for start in range(0, len(q), _BLOCK)]
        tip, now = arm.tree.joints[joint].tip, arm.gravity_in_base
        nominal = np.concatenate([_load(arm, tip, block, now) for block in blocks])
        if tilt is None:
            return cls(nominal, None, None, now, None)
        fixed = np.concatenate([_load(arm, tip, block, np.zeros(3)) for block in blocks])
        by_axis = [
            np.concatenate([_load(arm, tip, block, axis) for block in blocks]) - fixed
            for axis in np.eye(3)
        ]
        return cls(nominal, fixed, np.stack(by_axis, axis=-1), now, tilt)

    @classmethod
    def together(cls, each: Sequence[Self]) -> Self:
        """Return the loads of several links, for one section of all of them: the poses of one after
        those of the other.
        """
        fixed = [one.fixed for one in each if one.fixed is not None]
        by_gravity = [one.by_gravity for one in each if one.by_gravity is not None]
        return replace(
            each[0],
            nominal=np.concatenate([one.nominal for one in each]),
            fixed=np.concatenate(fixed) if fixed else None,
            by_gravity=np.concatenate(by_gravity) if by_gravity else None,
        )

    def at(self, poses: np.ndarray) -> LinkLoads:
        """Return the loads at some of the poses."""
        fixed, by_gravity = (
            None if each is None else each[poses] for each in (self.fixed, self.by_gravity)
        )
        return replace(self, nominal=self.nominal[poses], fixed=fixed, by_gravity=by_gravity)

    def at_pose(self, pose: int, gravity: Floats) -> Floats:
        """Return the load at one pose (9,) under this gravity; without a tilt, gravity is that of
        the base as stated.
        """
        if self.fixed is None or self.by_gravity is None:
            return np.asarray(self.nominal[pose])
        return np.asarray(self.fixed[pose] + self.by_gravity[pose] @ gravity)

    def deflections(self, link: ElasticLink) -> Floats:
        """Return slope (rad) and deflection (m) of the link's tip relative to the joint, across the
        link, at the worst tilt (pose, 2).

        As `load_causes.bending`, without components along the link. Over tilts to 1e-5: deflection
        is linear in gravity, so its maximum in a given direction is closed-form, and only the
        direction is searched.
        """
        compliance = _compliance(link)
        if self.fixed is None or self.by_gravity is None or self.tilt is None:
            components = (self.nominal @ compliance.T).reshape(-1, 2, 2)
            return np.asarray(np.sqrt(np.einsum("pma,pma->pm", components, components)))
        fixed, by_gravity = (
            self.fixed @ compliance.T,
            np.einsum("ab,pbi->pai", compliance, self.by_gravity)
            * float(np.linalg.norm(self.gravity)),
        )
        return np.column_stack(
            [
                _largest_over_tilts(fixed[:, rows], by_gravity[:, rows], self.tilt)
                for rows in (slice(0, 2), slice(2, 4))
            ]
        )

    def worst(self, link: ElasticLink) -> WorstDeflection:
        """Return the largest slope and deflection of the link."""
        values = self.deflections(link)
        slope, deflection = (int(each) for each in values.argmax(axis=0))
        return WorstDeflection(
            float(values[slope, 0]), slope, float(values[deflection, 1]), deflection
        )

    def worst_gravity(self, link: ElasticLink, pose: int, measure: int) -> Floats:
        """Return the gravity (3,) within the tilt with the largest slope (measure 0) or deflection
        (1) at a pose.
        """
        if self.tilt is None or self.fixed is None or self.by_gravity is None:
            return self.gravity
        size = float(np.linalg.norm(self.gravity))
        rows = _compliance(link)[2 * measure : 2 * measure + 2]
        fixed, slopes = rows @ self.fixed[pose], rows @ self.by_gravity[pose]
        angles = np.linspace(0, 2 * math.pi, _COARSE * _FINE)
        directions = np.column_stack([np.cos(angles), np.sin(angles)])
        best = int(_support(fixed[None], size * slopes[None], directions[None], self.tilt).argmax())
        return size * direction_within(directions[best] @ slopes, self.tilt)


def deflection_under(link: ElasticLink, load: Floats, measure: int) -> Floats:
    """Return the two components across a link (2,) of its slope (measure 0) or deflection (1) under
    a load (9,).
    """
    return np.asarray(_compliance(link)[2 * measure : 2 * measure + 2] @ load)


def _load(arm: Arm, tip: int, q: Floats, gravity: Floats) -> Floats:
    state = state_of(arm, q, gravity=gravity)
    return np.hstack([state.wrenches[tip], gravity @ state.frames[tip, :, :3, :3]])


def across(link: ElasticLink) -> Floats:
    """Return the matrix (2, 3) from a vector in the tip's axes to its two components across the
    link.
    """
    along = link.tip_from_joint @ link.link.tip_pose[:3, 3] / link.link.reach
    first = np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(along, first)])


def _compliance(link: ElasticLink) -> Floats:
    """Return the matrix (4, 9) from wrench on the tip and gravity to slope (2) and deflection (2)
    across the link.
    """
    return np.asarray(
        np.kron(np.eye(2), across(link))
        @ np.hstack([link.tip_compliance, link.own_weight_compliance])
    )


def _largest_over_tilts(fixed: Floats, by_gravity: Floats, tilt: float) -> Floats:
    """Return the largest norm (pose,) of fixed (pose, 2) + by_gravity (pose, 2, 3) @ d over unit
    vectors d within `tilt` of straight down.
    """
    angles = np.arange(_COARSE) * (2 * math.pi / _COARSE)
    best = np.zeros(len(fixed))
    for count, width in ((_COARSE, 0.0), (_FINE, 2 * math.pi / _COARSE)):
        tried = (
            np.broadcast_to(angles, (len(fixed), count))
            if not width
            else best[:, None] + np.linspace(-width, width, count)
        )
        directions = np.stack([np.cos(tried), np.sin(tried)], axis=-1)
        size = _support(fixed, by_gravity, directions, tilt)
        best = np.take_along_axis(tried, size.argmax(axis=1)[:, None], axis=1)[:, 0]
    return np.asarray(size.max(axis=1))


def _support(fixed: Floats, by_gravity: Floats, directions: Floats, tilt: float) -> Floats:
    """Return the largest component over tilts in each direction across the link (pose, direction,
    2): (pose, direction).
    """
    gradient = np.einsum("pka,pai->pki", directions, by_gravity)
    angle = np.arctan2(np.hypot(gradient[..., 0], gradient[..., 1]), -gradient[..., 2])
    size = np.sqrt(np.einsum("pki,pki->pk", gradient, gradient))
    return np.asarray(
        np.einsum("pka,pa->pk", directions, fixed) + size * np.cos(np.maximum(angle - tilt, 0.0))
    )
