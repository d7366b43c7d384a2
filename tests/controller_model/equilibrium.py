"""Soft arms and where they stand, without any code of the package: rotations of SciPy, forces and
moments about the base's origin, and the equilibrium by iteration from the command.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from lostmotion import Arm
from lostmotion.units import Toleranced

G = 9.80665
ITERATIONS = 60


@dataclass(frozen=True)
class SoftArm:
    """An arm of turning joints and straight links, SI.

    axes        (joint, 3) unit axes in each joint's own frame, parallel to the last one at zero
    tips        (joint, 3) from each joint to the next one, or to the tool
    masses      (joint,) of the links, in the middle of each
    payload     at the tool point
    springs     (joint,) along the axes, N m/rad; infinite: rigid
    tilting     (joint,) of the bearings, N m/rad; infinite: rigid
    bending     (joint, 6, 6) compliance of each link at its tip
    own_weight  (joint, 6, 3) twist of the tip per gravity in the link's axes
    play        (joint,) whole width of the play of each drive, rad
    friction    (joint,) torque below which the play is open, N m
    """

    axes: np.ndarray
    tips: np.ndarray
    masses: np.ndarray
    payload: float
    springs: np.ndarray
    tilting: np.ndarray
    bending: np.ndarray
    own_weight: np.ndarray
    play: np.ndarray
    friction: np.ndarray

    def moved(self, q, twists=None):
        """Return rotations and points of each joint seat and each link tip (pose, 2 joint, ...)."""
        count, joints = q.shape
        turn, point = np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros((count, 3))
        turns, points = [], []
        for k in range(joints):
            turn = turn @ Rotation.from_rotvec(q[:, k, None] * self.axes[k]).as_matrix()
            for place in (2 * k, 2 * k + 1):
                if place % 2:
                    point = point + turn @ self.tips[k]
                if twists is not None:
                    spin, shift = self.screwed(twists[:, place])
                    point = point + np.einsum("pij,pj->pi", turn, shift)
                    turn = turn @ spin
                turns.append(turn)
                points.append(point)
        return np.stack(turns, 1), np.stack(points, 1)

    @staticmethod
    def screwed(twist):
        """Return rotation and displacement of a screw motion, by an integral over its course."""
        at, weight = np.polynomial.legendre.leggauss(8)
        shift = sum(
            w / 2 * Rotation.from_rotvec((a + 1) / 2 * twist[:, :3]).apply(twist[:, 3:])
            for a, w in zip(at, weight, strict=True)
        )
        return Rotation.from_rotvec(twist[:, :3]).as_matrix(), shift

    def twists(self, turns, points, side):
        """Return the twists of all places (pose, 2 joint, 6) under the loads in these frames."""
        count, places = points.shape[:2]
        out = np.zeros((count, places, 6))
        down = np.array([0.0, 0.0, -G])
        force = np.broadcast_to(self.payload * down, (count, 3))
        moment = np.cross(points[:, -1], force)
        for place in range(places - 1, -1, -1):
            k, turn, point = place // 2, turns[:, place], points[:, place]
            about = moment - np.cross(point, force)
            load = np.concatenate(
                [np.einsum("pij,pi->pj", turn, each) for each in (about, force)], axis=1
            )
            if place % 2:
                out[:, place] = load @ self.bending[k].T
                out[:, place] += np.einsum("pij,i->pj", turn, down) @ self.own_weight[k].T
                # the mass is fixed to the joint's body, before the link bends
                body, seat = turns[:, place - 1], points[:, place - 1]
                force = force + self.masses[k] * down
                moment = moment + np.cross(seat + body @ (self.tips[k] / 2), self.masses[k] * down)
            else:
                torque = load[:, :3] @ self.axes[k]
                along = torque / self.springs[k]
                loaded = np.abs(torque) >= self.friction[k]
                along = along + self.play[k] / 2 * np.where(loaded, np.sign(torque), -side[:, k])
                across = (load[:, :3] - torque[:, None] * self.axes[k]) / self.tilting[k]
                out[:, place, :3] = along[:, None] * self.axes[k] + across
        return out

    def settled(self, command, side=None):
        """Return the tool's rotation and point at equilibrium, and the change in the last step, by
        which a pose without equilibrium is known.
        """
        side = np.zeros_like(command) if side is None else side
        twists = np.zeros((len(command), 2 * command.shape[1], 6))
        change, left = np.full(len(command), np.inf), np.arange(len(command))
        for _ in range(ITERATIONS):
            turns, points = self.moved(command[left], twists[left])
            found = self.twists(turns, points, side[left])
            change[left] = np.abs(found - twists[left]).max(axis=(1, 2))
            twists[left] = found
            left = left[change[left] >= 1e-15]  # a pose that stands still is left alone
            if not len(left):
                break
        turns, points = self.moved(command, twists)
        return turns[:, -1], points[:, -1], change

    def described(self):
        """Return the same arm for the package."""
        joints = []
        for k in range(len(self.axes)):
            drive = {
                "kind": "catalogue",
                "ratio": 100.0,
                "friction_torque": Toleranced(float(self.friction[k]), 1e-9),
            }
            if np.isfinite(self.springs[k]):
                drive["stiffness"] = float(self.springs[k])
            if self.play[k]:
                drive["backlash"] = float(self.play[k])
            joint = {
                "name": f"J{k}",
                "type": "revolute",
                "axis": tuple(self.axes[k].tolist()),
                "limits": (-3.0, 3.0),
                "gearbox": drive,
                "link": {
                    "tip": {"xyz": tuple(self.tips[k].tolist())},
                    "mass": float(self.masses[k]),
                    "centre_of_mass": tuple((self.tips[k] / 2).tolist()),
                },
            }
            if np.isfinite(self.tilting[k]):
                joint["bearing"] = {
                    "kind": "crossed roller",
                    "moment_stiffness": float(self.tilting[k]),
                }
            if self.bending[k].any():
                joint["link"]["compliance"] = {
                    "matrix": tuple(map(tuple, self.bending[k].tolist())),
                    "own_weight": tuple(map(tuple, self.own_weight[k].tolist())),
                }
            else:
                joint["link"]["rigid"] = True
            joints.append(joint)
        return Arm(name="soft", joints=joints, payload={"mass": self.payload})


def soft_arm(seed, joints, *, droop=0.01, bend=0.0, play=0.0):
    """Return a random arm whose drives droop, and whose bearings and links bend, by about these
    angles under the largest load.
    """
    rng = np.random.default_rng(seed)
    axes = np.eye(3)[rng.integers(0, 3, joints)]
    axes[0], axes[1:3] = [0, 0, 1], [0, 1, 0]
    tips = rng.uniform(-0.05, 0.05, (joints, 3))
    tips[np.arange(joints), rng.integers(0, 3, joints)] += rng.uniform(0.15, 0.4, joints)
    masses, payload = rng.uniform(0.2, 1.5, joints), float(rng.uniform(0.3, 2.0))
    reach = np.cumsum(np.linalg.norm(tips, axis=1)[::-1])[::-1]
    outboard = np.cumsum(masses[::-1])[::-1] + payload
    largest = outboard * G * reach
    rigid = np.full(joints, np.inf)
    bending, own_weight = np.zeros((joints, 6, 6)), np.zeros((joints, 6, 3))
    for k in range(joints) if bend else ():
        # slopes and deflections of a uniform cantilever by force and moment at its end, then its
        # own weight, turned so that x points along the link
        length, ei = np.linalg.norm(tips[k]), largest[k] * np.linalg.norm(tips[k]) / bend
        c = np.diag([1.3, 1, 1, 0, 0, 0]) * length / ei
        c[4, 4] = c[5, 5] = length**3 / (3 * ei)
        c[3, 3] = 1e-3 * c[4, 4]
        c[4, 2] = c[2, 4] = length**2 / (2 * ei)
        c[5, 1] = c[1, 5] = -(length**2) / (2 * ei)
        w = np.zeros((6, 3))
        w[4, 1] = w[5, 2] = masses[k] * length**3 / (8 * ei)
        w[2, 1], w[1, 2] = masses[k] * length**2 / (6 * ei), -masses[k] * length**2 / (6 * ei)
        turn = Rotation.align_vectors(tips[k][None] / length, [[1.0, 0, 0]])[0].as_matrix()
        both = np.kron(np.eye(2), turn)
        bending[k], own_weight[k] = both @ c @ both.T, both @ w @ turn.T
    return SoftArm(
        axes,
        tips,
        masses,
        payload,
        largest / droop if droop else rigid,
        largest / bend if bend else rigid,
        bending,
        own_weight,
        np.full(joints, play),
        0.02 * largest,
    )
