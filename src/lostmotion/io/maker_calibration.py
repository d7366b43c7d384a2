"""Calibrations by makers of arms: Universal Robots' calibration.conf, and the kinematics YAML that
ROS drivers extract from it.

calibration.conf holds differences delta_theta, delta_a, delta_d and delta_alpha to the rows of a
standard Denavit-Hartenberg table. Where two axes are nearly parallel, they may be hundreds of
metres, since the common normal of such axes is anywhere. As frames of a chain they are harmless.
"""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.io.text import read_text, refuse
from lostmotion.mechanism.state import state_of
from lostmotion.spatial import inverse, pose_of, shift

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_EXAMPLE: Final = "delta_theta = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]"
_ROW: Final = re.compile(r"^\s*delta_(theta|a|d|alpha)\s*=\s*\[([^\]]*)\]", re.MULTILINE)
_KEYS: Final = ("x", "y", "z", "roll", "pitch", "yaw")
_LINE: Final = re.compile(r"^(\s*)([A-Za-z_0-9]+)\s*:\s*([^#]*?)\s*(?:#.*)?$")
# A step that differs from a Denavit-Hartenberg row by more than this is none, m and rad.
_CLOSE: Final = 1e-9
_MEGABYTES: Final = 1


@dataclass(frozen=True, eq=False)
class MakerChain:
    """A calibrated chain: frames (joint + 1, 4, 4), m, before each joint, which turns about z, and
    after the last one.

    with_tool  whether the last frame is that of the arm's tool; else it is that of the last joint
    """

    steps: Floats
    with_tool: bool

    def tool(self, q: Floats) -> Floats:
        """Return the frames of the tool (pose, 4, 4), m, for joint values q (pose, joint), rad."""
        out = np.broadcast_to(self.steps[0], (len(q), 4, 4))
        for step, angle in zip(self.steps[1:], q.T, strict=True):
            turned = np.zeros((len(q), 4, 4))
            turned[:, 0, 0] = turned[:, 1, 1] = np.cos(angle)
            turned[:, 1, 0] = np.sin(angle)
            turned[:, 0, 1] = -turned[:, 1, 0]
            turned[:, 2, 2] = turned[:, 3, 3] = 1.0
            out = out @ turned @ step
        return out


def read_maker_calibration(path: Path, arm: Arm) -> MakerChain:
    """Return the calibrated chain of an arm by its maker's file. Raises InputError for a file of
    another kind, and for one of another number of joints.
    """
    text, file = read_text(path, _MEGABYTES, "my_robot_calibration.yaml"), str(path)
    rows = {name: _numbers(file, name, cells) for name, cells in _ROW.findall(text)}
    if rows:
        return _of_differences(file, rows, arm)
    return _of_frames(file, text, arm)


def _numbers(file: str, name: str, cells: str) -> Floats:
    try:
        found = np.array([float(cell) for cell in cells.split(",") if cell.strip()])
    except ValueError:
        refuse(file, f"delta_{name}", cells, "numbers", _EXAMPLE)
    if not np.isfinite(found).all():
        refuse(file, f"delta_{name}", cells, "finite numbers", _EXAMPLE)
    return found


def _of_differences(file: str, rows: dict[str, Floats], arm: Arm) -> MakerChain:
    count = len(arm.driven)
    for name in ("theta", "a", "d", "alpha"):
        if name not in rows or len(rows[name]) != count:
            found = f"{len(rows.get(name, ()))} numbers"
            refuse(file, f"delta_{name}", found, f"{count}, one for each joint", _EXAMPLE)
    first, *between, last = _nominal(arm)
    steps = [first]
    for k, step in enumerate(between):
        theta, d, a, alpha = _row(file, step, arm.driven[k].name)
        values = (("theta", theta), ("d", d), ("a", a), ("alpha", alpha))
        steps.append(_dh(*(value + rows[name][k] for name, value in values)))
    steps.append(_dh(rows["theta"][-1], rows["d"][-1], rows["a"][-1], rows["alpha"][-1]) @ last)
    return MakerChain(np.array(steps), with_tool=True)


def _dh(theta: float, d: float, a: float, alpha: float) -> Floats:
    """Return Rz(theta) Tz(d) Tx(a) Rx(alpha)."""
    return pose_of(rpy=(0, 0, theta)) @ shift(a, 0, d) @ pose_of(rpy=(alpha, 0, 0))


def _nominal(arm: Arm) -> list[Floats]:
    """Return the frames (4, 4) before each joint and after the last one, all joints at zero."""
    at = state_of(arm, np.zeros((1, len(arm.driven)))).frames[:, 0]
    places = [0, *(arm.tree.moved[joint] for joint in arm.tree.tool_joints), len(at) - 1]
    return [inverse(at[before]) @ at[after] for before, after in itertools.pairwise(places)]


def _row(file: str, step: Floats, name: str) -> tuple[float, float, float, float]:
    """Return theta, d, a and alpha of a step between two joints."""
    theta = math.atan2(step[1, 0], step[0, 0])
    alpha = math.atan2(step[2, 1], step[2, 2])
    a = step[0, 3] * math.cos(theta) + step[1, 3] * math.sin(theta)
    d = float(step[2, 3])
    if np.abs(_dh(theta, d, a, alpha) - step).max() > _CLOSE:
        expected = "an arm by a standard Denavit-Hartenberg table, as the maker's file assumes"
        refuse(file, name, "a link that is no row of such a table", expected, "dh = { ... }")
    return theta, d, a, alpha


def _of_frames(file: str, text: str, arm: Arm) -> MakerChain:
    """Return the chain of a kinematics YAML: for each joint x, y, z, roll, pitch and yaw."""
    frames: list[dict[str, float]] = []
    for line in text.splitlines():
        match = _LINE.match(line)
        if match is None:
            continue
        if not match[3] and match[2] != "kinematics":
            frames.append({})
        elif match[2] in _KEYS and frames:
            try:
                frames[-1][match[2]] = float(match[3])
            except ValueError:
                refuse(file, match[2], match[3], "a number", "x: 0.0")
    whole = [each for each in frames if set(each) == set(_KEYS)]
    if len(whole) != len(arm.driven):
        found = f"{len(whole)} frames with x, y, z, roll, pitch and yaw"
        expected = f"{len(arm.driven)}, one for each joint; or calibration.conf"
        refuse(file, "kinematics", found, expected, "shoulder:\n    x: 0.0")
    steps = [
        pose_of((each["x"], each["y"], each["z"]), (each["roll"], each["pitch"], each["yaw"]))
        for each in whole
    ]
    return MakerChain(np.array([*steps, np.eye(4)]), with_tool=False)
