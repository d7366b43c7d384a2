"""Where does the arm give, by which parts, and what does every joint carry? The whole workspace, still, without chance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.elastostatics import Ellipsoid, compliances, deflection, ellipsoid
from lostmotion.mechanism.holding_torques import Node, static_moments
from lostmotion.mechanism.serial import frames
from lostmotion.spatial import cross

if TYPE_CHECKING:
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_BLOCK: Final = 4096


@dataclass(frozen=True, repr=False)
class Survey:
    """What was found; over poses in their order.

    nodes    what each moving joint carries at worst; `tilt` (rad) of the base allowed for, None where none was stated
    tool     (pose, 3) m
    softest  (pose,) m/N, the compliance along the softest direction, the tool free to turn; mean (pose,) over all directions
    sag      (pose,) m, by how much the payload's weight moves the tool, on top of all else; None without payload
    asymmetry  (pose,) as `Compliances.asymmetry`
    parts    that give, and their mean share of `mean` over poses (part,)
    worst    the pose with the softest direction of all; there compliance (6, 6), share (part,), and the ellipsoids with the tool free to turn, its
             turning held, and (rad/(N m)) of its turning under a moment
    """

    arm: Arm
    poses: Poses
    tilt: float | None
    nodes: list[Node]
    tool: Floats
    softest: Floats
    mean: Floats
    asymmetry: Floats
    sag: Floats | None
    parts: tuple[str, ...]
    shares: Floats
    worst: int
    compliance: Floats
    worst_shares: Floats
    free: Ellipsoid
    held: Ellipsoid
    turning: Ellipsoid


def survey(arm: Arm, poses: Poses, tilt: float | None = None) -> Survey:
    """What do the joints of this arm carry over these poses, and how much does it give there? tilt (rad) as `static_moments`."""
    q = poses.q
    blocks = [q[start : start + _BLOCK] for start in range(0, len(q), _BLOCK)]
    found = [compliances(arm, block) for block in blocks]
    softest = np.concatenate([ellipsoid(each.whole).values[:, 0] for each in found])
    give = np.concatenate([each.give for each in found], axis=1)
    mean = give.sum(axis=0)
    with np.errstate(invalid="ignore"):
        shares = give / mean
    worst = int(softest.argmax())
    there = compliances(arm, q[[worst]]).whole
    turned = np.roll(there, 3, axis=(1, 2))  # rotation and displacement change places
    return Survey(
        arm,
        poses,
        tilt,
        static_moments(arm, q, tilt),
        np.concatenate([each.tool for each in found]),
        softest,
        mean,
        np.concatenate([each.asymmetry for each in found]),
        np.concatenate([_sag(arm, block) for block in blocks]) if arm.payload.mass else None,
        found[0].parts,
        shares.mean(axis=1),
        worst,
        there[0],
        shares[:, worst],
        ellipsoid(there),
        ellipsoid(there, rotation_held=True),
        ellipsoid(turned),
    )


def _sag(arm: Arm, q: Floats) -> Floats:
    """Give by how much the payload's weight moves the tool (pose,), m: what it takes back when it is lifted off."""
    at = frames(arm, q)[-1]
    weight = np.broadcast_to(arm.payload.mass * arm.gravity_in_base, (len(q), 3))
    lever = at[:, :3, :3] @ np.array(arm.payload.centre_of_mass)
    return np.asarray(np.linalg.norm(deflection(arm, q, -np.hstack([cross(lever, weight), weight]))[:, 3:], axis=1))
