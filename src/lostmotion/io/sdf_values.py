"""Numbers and poses of an SDF file, with every mistake noted at its line."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import Problem, shown
from lostmotion.io.sdf_xml import TRUE, place
from lostmotion.io.text import numbers
from lostmotion.io.urdf_tree import LARGEST_NUMBER
from lostmotion.spatial import pose_by_quaternion, pose_of

if TYPE_CHECKING:
    from lxml import etree

    from lostmotion.io.urdf_tree import UrdfTree
    from lostmotion.spatial import Floats

_EULER: Final = "euler_rpy"
_QUATERNION: Final = "quat_xyzw"
# Each with the numbers of no motion.
_FORMATS: Final = {_EULER: (0.0,) * 6, _QUATERNION: (*(0.0,) * 6, 1.0)}
# What SDF writes for no limit at all.
_ENDLESS: Final = 1e16
_INFINITE: Final = {"inf": math.inf, "+inf": math.inf, "-inf": -math.inf}
_NO_NORM: Final = 1e-9


class Values:
    """Reads the text of elements into numbers. Mistakes go to `mistakes`, those of the tree unless
    set.
    """

    def __init__(self, tree: UrdfTree) -> None:
        """Begin with the mistakes of a tree."""
        self.tree = tree
        self.mistakes = tree.mistakes

    def refuse(self, element: etree._Element, path: str, *words: str) -> None:
        """Note a mistake: what was found, what is expected, an example, and the nearest name."""
        if not self.tree.full:
            self.mistakes.append(Problem(place(element, self.tree.file), path, *words))

    def row(
        self, element: etree._Element | None, path: str, default: tuple[float, ...], example: str
    ) -> tuple[float, ...]:
        """Return as many numbers as the default has, which holds where there is no element."""
        if element is None:
            return default
        text = (element.text or "").strip()
        try:
            values = tuple(numbers(text.split()))
        except ValueError:
            values = ()
        if len(values) == len(default) and all(abs(value) <= LARGEST_NUMBER for value in values):
            return values
        count = "a finite number" if len(default) == 1 else f"{len(default)} finite numbers"
        self.refuse(element, path, shown(text), f"{count} in plain decimal notation", example)
        return default

    def limit(self, element: etree._Element | None, path: str, default: float) -> float:
        """Return a limit, infinite where the joint has none."""
        if element is None:
            return default
        text = (element.text or "").strip().lower()
        if text in _INFINITE:
            return _INFINITE[text]
        try:
            if abs(numbers([text])[0]) >= _ENDLESS:
                return default
        except ValueError:
            pass
        return self.row(element, path, (default,), f"<{element.tag}>1.57</{element.tag}>")[0]

    def pose(self, parent: etree._Element, path: str) -> Floats:
        """Return the pose (4, 4) that an element states, m; the identity where it states none."""
        element = parent.find("pose")
        if element is None or not (element.text or "").strip():
            return pose_of()
        kind = element.get("rotation_format", _EULER)
        if kind not in _FORMATS:
            expected = f"one of {', '.join(_FORMATS)}"
            self.refuse(
                element, f"{path}/pose/@rotation_format", shown(kind), expected, f'"{_EULER}"'
            )
            return pose_of()
        still = _FORMATS[kind]
        example = f"<pose>{' '.join(f'{value:g}' for value in still)}</pose>"
        stated = self.row(element, f"{path}/pose", still, example)
        x, y, z = stated[:3]
        if kind == _EULER:
            factor = math.pi / 180 if element.get("degrees", "") in TRUE else 1.0
            roll, pitch, yaw = (factor * angle for angle in stated[3:])
            return pose_of((x, y, z), (roll, pitch, yaw))
        norm = math.hypot(*stated[3:])
        if norm < _NO_NORM:
            expected = "a rotation as x y z w"
            self.refuse(element, f"{path}/pose", "a quaternion of zeros", expected, "0 0 0 1")
            return pose_of((x, y, z))
        return pose_by_quaternion((x, y, z), np.roll(stated[3:], 1) / norm)
