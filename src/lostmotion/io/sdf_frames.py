"""Frames of an SDF model: those of models, links, joints, and named ones, each stated relative to
another.

Names of a nested model begin with NAME::. Unless stated, a pose is relative to the model; that of a
joint to its child, that of a named frame to what it is attached to.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import shown
from lostmotion.io.limits import nearest
from lostmotion.io.sdf_xml import place
from lostmotion.io.text import refuse
from lostmotion.io.urdf_tree import LONGEST_NAME, MOST_ELEMENTS, is_name

if TYPE_CHECKING:
    from lxml import etree

    from lostmotion.io.sdf_values import Values
    from lostmotion.spatial import Floats

WORLD: Final = "world"
MODEL: Final = "__model__"
_BETWEEN: Final = "::"
# In the order in which one of a name has it: links and joints of older files may share one.
_KINDS: Final = ("link", "model", "frame", "joint")


@dataclass
class _Frame:
    """A frame: its element, the scope in which its references count, its pose (4, 4) in `base`, and
    what it is fixed to; of a joint its parent too. Names.
    """

    kind: str
    scope: str
    element: etree._Element
    raw: Floats
    base: str = ""
    attached: str = ""
    parent: str = ""

    @property
    def path(self) -> str:
        return f'//{self.kind}[@name="{self.element.get("name", "")}"]'


class Frames:
    """The frames of a model, seen from that model.

    links, joints  the elements by name, in their order
    """

    def __init__(self, model: etree._Element, values: Values) -> None:
        """Read the frames; mistakes are noted in `values`."""
        self.values = values
        self.links: dict[str, etree._Element] = {}
        self.joints: dict[str, _Frame] = {}
        self.named: list[str] = []
        self._frames: dict[str, _Frame] = {}
        self._joint_frames: dict[str, str] = {}
        self._poses: dict[str, Floats] = {MODEL: np.eye(4)}
        count = sum(1 for _ in model.iter(*_KINDS))
        if count > MOST_ELEMENTS:
            found = f"{count} links, joints, models and frames"
            refuse(
                place(model, values.tree.file),
                "//model",
                found,
                f"at most {MOST_ELEMENTS}",
                "one arm",
            )
        self._top = _Frame("model", "", model, values.pose(model, "//model"))
        self._frames[MODEL] = self._top
        self._scan(model, "")
        for name, frame in self._frames.items():
            self._relate(name, frame)
        if not values.mistakes:
            self._find_circles()

    def _scan(self, model: etree._Element, scope: str) -> None:
        """Register what stands in a model."""
        for kind in _KINDS:
            taken: set[str] = set()
            for element in model.iterchildren(kind):
                name = element.get("name", "").strip()
                path = f"//{kind}/@name"
                if not is_name(scope + name) or not name or name in taken:
                    found = f"the name {shown(name)} twice" if name in taken else shown(name)
                    expected = (
                        f"a name of its own, in one line of at most {LONGEST_NAME} characters"
                    )
                    self.values.refuse(element, path, found, expected, f'<{kind} name="{kind}_1">')
                    continue
                taken.add(name)
                self._register(kind, scope, name, element)

    def _register(self, kind: str, scope: str, name: str, element: etree._Element) -> None:
        whole = scope + name
        frame = _Frame(kind, scope, element, np.eye(4))
        frame.raw = self.values.pose(element, frame.path)
        if kind == "model":
            whole += _BETWEEN + MODEL
            self._scan(element, scope + name + _BETWEEN)
        elif kind == "link":
            self.links[whole] = element
        elif kind == "joint":
            self.joints[whole] = frame
        while whole in self._frames:  # of another kind: no pose names it
            whole += f" ({kind})"
        if kind == "frame":
            self.named.append(whole)
        elif kind == "joint":
            self._joint_frames[scope + name] = whole
        self._frames[whole] = frame

    def _end(self, joint: _Frame, end: str) -> str:
        element = joint.element.find(end)
        text = "" if element is None else (element.text or "").strip()
        return self._stated(joint, joint.element if element is None else element, end, text)

    def resolve(self, scope: str, stated: str) -> str:
        """Return the whole name of a frame that is stated within a scope; empty where there is
        none.
        """
        if stated == WORLD and WORLD not in self.links:  # which older files may name a link
            return WORLD
        name = scope + stated
        inner = name + _BETWEEN + MODEL
        return name if name in self._frames else inner if inner in self._frames else ""

    def _stated(self, frame: _Frame, element: etree._Element, what: str, stated: str) -> str:
        """Return the whole name of a frame that an element names; note a mistake, and return the
        model's, where there is none.
        """
        found = self.resolve(frame.scope, stated)
        if not found:
            known = [name.removeprefix(frame.scope) for name in self._frames]
            near = nearest(stated, known)
            self.values.refuse(
                element,
                f"{frame.path}/{what}",
                shown(stated),
                "the name of a link, joint, frame or nested model of this model",
                near or next(iter(self.links), "base"),
                near,
            )
        return found or MODEL

    def _relate(self, name: str, frame: _Frame) -> None:
        """Find what the pose of a frame is relative to, and what it is fixed to."""
        element = frame.element
        frame.base = frame.attached = frame.scope + MODEL
        if frame.kind == "joint":
            frame.parent, frame.base = (self._end(frame, end) for end in ("parent", "child"))
            frame.attached = frame.base
        elif frame.kind == "frame" and (text := element.get("attached_to", "")):
            frame.base = frame.attached = self._stated(frame, element, "@attached_to", text)
        elif frame.kind == "link":
            frame.attached = name
        elif frame.kind == "model":
            inner = name.removesuffix(MODEL)
            first = next((link for link in self.links if link.startswith(inner)), WORLD)
            canonical = element.get("canonical_link", "")
            frame.attached = (self.resolve(inner, canonical) if canonical else "") or first
            at = element.get("placement_frame", "")
            if at and not self.resolve(inner, at):
                self._stated(frame, element, "@placement_frame", f"{inner}{at}")
        pose = element.find("pose")
        if pose is not None and frame is not self._top:
            text = pose.get("relative_to", pose.get("frame", ""))
            if text:
                frame.base = self._stated(frame, pose, "pose/@relative_to", text)

    def _find_circles(self) -> None:
        """Note frames that are stated relative to themselves, and those that hang on themselves."""
        for ends in ("base", "attached"):
            sound = {MODEL, WORLD, *(self.links if ends == "attached" else ())}
            for name, frame in self._frames.items():
                way: dict[str, None] = {}
                at = name
                while at not in sound and at not in way:
                    way[at] = None
                    at = getattr(self._frames[at], ends)
                if at in way:
                    found = f"a frame that leads round to itself: {shown(name)}"
                    self.values.refuse(
                        frame.element,
                        frame.path,
                        found,
                        "poses that lead to the model",
                        '<pose relative_to="__model__">',
                    )
                    return
                sound |= way.keys()

    def pose_of(self, name: str) -> Floats:
        """Return the pose (4, 4) of a frame in the model; to be asked where there are no
        mistakes.
        """
        way = []
        while name not in self._poses and name in self._frames:
            way.append(name)
            name = self._frames[name].base
        pose = self._poses[name] if name in self._poses else self._world()
        for each in reversed(way):
            pose = self._poses[each] = pose @ self._seat(each)
        return pose

    def of_joint(self, name: str) -> Floats:
        """Return the pose (4, 4) of a joint in the model."""
        return self.pose_of(self._joint_frames[name])

    def _world(self) -> Floats:
        """Return the pose of the world in the model, which stands in it at its pose."""
        return np.asarray(np.linalg.inv(self._placed(self._top, "")), dtype=float)

    def _seat(self, name: str) -> Floats:
        frame = self._frames[name]
        return self._placed(frame, name.removesuffix(MODEL)) if frame.kind == "model" else frame.raw

    def _placed(self, model: _Frame, scope: str) -> Floats:
        """Return the pose of a model, which its placement frame has where one is named."""
        stated = model.element.get("placement_frame", "")
        if not stated:
            return model.raw
        inner, at = np.eye(4), self.resolve(scope, stated)
        while at and at != scope + MODEL and at != WORLD:
            inner, at = self._seat(at) @ inner, self._frames[at].base
        return np.asarray(model.raw @ np.linalg.inv(inner), dtype=float)

    def body_of(self, name: str) -> str:
        """Return the link that a frame is fixed to, or the world."""
        while name not in self.links and name != WORLD:
            name = self._frames[name].attached
        return name
