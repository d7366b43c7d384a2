"""The position of a hexapod by Pinocchio: its kinematics and Jacobians in C++, and a Newton loop in
Python over the closures, each a point of a leg that is one with a point of the platform.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion import Arm

_MOST_STEPS = 50
_CLOSED = 1e-12  # m


class Hexapod:
    """An arm of free, universal, prismatic and ball joints, whose balls close its loops."""

    def __init__(self, arm: Arm) -> None:
        self.model = pin.Model()
        ends: dict[str, tuple[int, pin.SE3]] = {}
        last = (0, pin.SE3.Identity())
        for joint in arm.joints:
            parent, seat = (0, pin.SE3.Identity()) if joint.after == "base" else last
            seat = seat * pin.SE3(joint.origin.pose)
            for motion in _MOTIONS[joint.type]:
                name = f"{joint.name}{self.model.njoints}"
                parent, seat = (
                    self.model.addJoint(parent, motion(), seat, name),
                    pin.SE3.Identity(),
                )
            if joint in arm.driven:
                ends[joint.name] = (parent, seat)
            last = ends[f"{joint.name}.tip"] = (parent, seat * pin.SE3(joint.link.tip_pose))
        self.platform = ends["platform.tip"][0]
        drives = [self.model.joints[ends[joint.name][0]] for joint in arm.driven]
        self.q_of_drives = [drive.idx_q for drive in drives]
        self.driven = np.array([drive.idx_v for drive in drives])
        self.passive = np.setdiff1d(np.arange(self.model.nv), self.driven)
        self.points = [
            [
                self.model.addFrame(
                    pin.Frame(
                        f"{k}{place}",
                        ends[place][0],
                        ends[place][1] * pin.SE3(frame.pose),
                        pin.OP_FRAME,
                    )
                )
                for place, frame in zip(closure.joins, closure.frames, strict=True)
            ]
            for k, closure in enumerate(arm.closures)
        ]
        self.data = self.model.createData()
        start = pin.neutral(self.model)
        start[:3] = next(joint.start.xyz for joint in arm.joints if joint.type == "free")
        middle = np.array([sum(joint.limits) / 2 for joint in arm.driven])
        self.home, _ = self.solved(start, middle, _least)  # the legs may stand singularly at first

    def tool(self, drives: np.ndarray) -> np.ndarray:
        """Return the pose (4, 4) of the platform, found from home, and solve for the motion of the
        passive freedoms per motion of the drives.
        """
        _, jacobian = self.solved(self.home, drives, np.linalg.solve)
        np.linalg.solve(jacobian[:, self.passive], jacobian[:, self.driven])
        return self.data.oMi[self.platform].homogeneous

    def solved(
        self,
        start: np.ndarray,
        drives: np.ndarray,
        solve: Callable[[np.ndarray, np.ndarray], np.ndarray],
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the configuration at values of the drives, and the Jacobian of the closures."""
        q = start.copy()
        q[self.q_of_drives] = drives
        for _ in range(_MOST_STEPS):
            pin.computeJointJacobians(self.model, self.data, q)
            pin.updateFramePlacements(self.model, self.data)
            apart = np.concatenate(
                [
                    self.data.oMf[b].translation - self.data.oMf[a].translation
                    for a, b in self.points
                ]
            )
            jacobian = np.vstack([self._jacobian(a) - self._jacobian(b) for a, b in self.points])
            if np.abs(apart).max() < _CLOSED:
                break
            step = np.zeros(self.model.nv)
            step[self.passive] = solve(jacobian[:, self.passive], apart)
            q = pin.integrate(self.model, q, step)
        return q, jacobian

    def _jacobian(self, frame: int) -> np.ndarray:
        world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        return pin.getFrameJacobian(self.model, self.data, frame, world)[:3]


_MOTIONS = {
    "free": (pin.JointModelFreeFlyer,),
    "universal": (pin.JointModelRX, pin.JointModelRY),
    "prismatic": (pin.JointModelPZ,),
    "spherical": (),
}


def _least(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    return np.linalg.lstsq(matrix, right, rcond=1e-9)[0]
