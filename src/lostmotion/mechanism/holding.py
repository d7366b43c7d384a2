"""The largest static load of each joint of an arm. Friction that is not stated is assumed in
proportion to it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.closed_arrays import ASSEMBLED
from lostmotion.mechanism.closed_chain import assembly_of, closed_statics
from lostmotion.mechanism.frames import place_frames
from lostmotion.mechanism.wrenches import process_wrenches, weights_by_axis
from lostmotion.parts.term import Holding
from lostmotion.spatial import mapped, out_of

if TYPE_CHECKING:
    from lostmotion.mechanism.places import Tree
    from lostmotion.mechanism.tool import Payload
    from lostmotion.spatial import Floats

_POSES: Final = 256


def holding_loads(
    tree: Tree, limits: Floats, payload: Payload, gravity: float, least: float
) -> tuple[Holding, ...]:
    """Return the largest static load of each joint, moving or fixed, over all tilts of the base and
    over poses between the joint limits.

    limits   (joint, 2) rad or m, of the moving joints
    gravity  magnitude of the acceleration of free fall, m/s^2
    least    weight (N) at the arm's reach that every joint is assumed to hold at least

    Gravity acts on everything outboard of a joint in the direction that loads the joint most, and
    the process force adds to it with its magnitude.
    """
    q = spread_evenly(limits)
    closed = assembly_of(tree, q)
    at = place_frames(tree, q) if closed is None else closed.frames[:, closed.problem == ASSEMBLED]
    by_axis = weights_by_axis(tree, at, payload)
    process = process_wrenches(tree, at, payload)
    if closed is not None:  # of rigid parts: an assumption needs no springs
        loops, process = closed_statics(tree, at, process, lambda _: ())
        by_axis = np.stack([loops.wrenches(each) for each in by_axis])
    start = at[tree.places[tree.moved[tree.tool_joints[0]]].parent, :, :3, 3]
    centres = [
        payload.centre_of_mass,
        *(weight.centre for weight in tree.masses if weight.at == len(at) - 1),
    ]
    ends = [
        at[-1, :, :3, 3] + out_of(at[-1], np.array(centre))
        for centre in ((0.0, 0.0, 0.0), *centres)
    ]
    reach = max(float(np.linalg.norm(end - start, axis=-1).max()) for end in ends)
    out = []
    for _, moved, _ in tree.joints:
        twist = tree.places[moved].twist
        along = twist[:, 0] if twist.shape[1] == 1 else np.zeros(6)
        weights, process_wrench = by_axis[:, moved], process[moved]
        # Under the worst direction of gravity: the load along the joint, the moment of a horizontal
        # lever arm, and the weight.
        load = np.linalg.norm([mapped(along, weight) for weight in weights], axis=0)
        moment = np.linalg.norm(weights[..., :3], axis=(0, 2)) / math.sqrt(2)
        force = np.linalg.norm(weights[..., 3:], axis=(0, 2)) / math.sqrt(3)
        most = [
            float((gravity * weight + more).max())
            for weight, more in (
                (load, np.abs(mapped(along, process_wrench))),
                (force, np.linalg.norm(process_wrench[:, 3:], axis=1)),
                (moment, np.linalg.norm(process_wrench[:, :3], axis=1)),
            )
        ]
        floor = least * (reach if along[:3].any() else 1.0), least, least * reach
        out.append(Holding(*map(max, most, floor)))
    return tuple(out)


def spread_evenly(limits: Floats, poses: int = _POSES) -> Floats:
    """Return poses (pose, joint) between limits (joint, 2), 256 unless stated: a deterministic
    sequence that adds powers of the generalised golden ratio, modulo one.

    Source: M. Roberts, The unreasonable effectiveness of quasirandom sequences, 2018.
    """
    joints = len(limits)
    ratio = 2.0
    for _ in range(60):
        ratio = (1 + ratio) ** (1 / (joints + 1))  # the root of x^(joints + 1) = x + 1
    share = (0.5 + np.arange(poses)[:, None] * ratio ** -np.arange(1.0, joints + 1)) % 1.0
    return limits[:, 0] + share * (limits[:, 1] - limits[:, 0])
