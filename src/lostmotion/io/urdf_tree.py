"""The links and joints of a description as one tree, checked as a whole; meshes, materials and
extensions are never read.

Mistakes that count only where a joint moves the tool (axis, limits, type) stay with the joint:
beside the chain it is held at zero.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from lostmotion.errors import Problem, shown
from lostmotion.io.limits import MOST_MISTAKES, listed, nearest
from lostmotion.units import LARGEST

if TYPE_CHECKING:
    from collections.abc import Collection

    from lostmotion.spatial import Floats

Three = tuple[float, float, float]
_ZERO: Final = (0.0, 0.0, 0.0)
LIMITED: Final = ("revolute", "prismatic")
MOVING: Final = (*LIMITED, "continuous")
# What loops alone move: a ball joint, and a platform that legs carry.
_IN_LOOPS: Final = ("ball", "floating")
MOST_ELEMENTS: Final = 1000
# Of a number in the file: sums along a chain of poses stay below what an arm may have.
LARGEST_NUMBER: Final = LARGEST / 1000
LONGEST_NAME: Final = 200  # as programs join them; a joint of the arm has a shorter one


@dataclass(frozen=True, slots=True)
class NamedTips:
    """Links that an SRDF names as tools, best first, and the name of the file."""

    file: str
    links: tuple[str, ...]


@dataclass
class UrdfLink:
    """A body: its mass (kg), and the centre of it (m) in its frame; `is_frame` where it has neither
    mass nor shape.
    """

    name: str
    mass: float = 0.0
    centre: Three = _ZERO
    is_frame: bool = False


@dataclass(frozen=True)
class UrdfLoop:
    """A constraint that joins two links: their names, a frame (4, 4) in each, m, and whether these
    may turn about their common origin.
    """

    name: str
    links: tuple[str, str]
    frames: tuple[Floats, Floats]
    turns: bool


@dataclass
class UrdfJoint:
    """A joint as the file states it: m, rad, axis of any length; `line` and `path` say where it
    stands.

    limits    lower and upper, rad or m; zeros for types without; of a ball joint zero and the
              largest angle between `axis` and the same direction of the moved side
    effort    largest torque or force of its drive, N m or N, as stated: many files state a
              placeholder; 0 where none is
    leader    the joint that it follows (mimic), and `coupling` how; empty where it follows none
    in_loop   whether a constraint between two bodies closes a loop through it
    driven    whether a drive moves it, should a loop lead through it
    limit_mistakes, other_mistakes  what is wrong with its limits, and with its type or axis: it
                                    counts only where the joint is on the chain root      what
                                    stands before its element in an XPath
    repaired  what a sidecar states in place of the description: "limits", "mass", "centre_of_mass"
              of the link behind it
    """

    name: str
    type: str
    parent: str
    child: str
    xyz: Three
    rpy: Three
    line: int
    axis: Three = (1.0, 0.0, 0.0)
    limits: tuple[float, float] = (0.0, 0.0)
    effort: float = 0.0
    leader: str = ""
    coupling: str = ""
    in_loop: bool = False
    driven: bool = True
    limit_mistakes: list[Problem] = field(default_factory=list)
    other_mistakes: list[Problem] = field(default_factory=list)
    root: str = "/robot"
    repaired: set[str] = field(default_factory=set)

    @property
    def mistakes(self) -> list[Problem]:
        """Return everything that is wrong with the joint."""
        return [*self.limit_mistakes, *self.other_mistakes]

    @property
    def locked(self) -> bool:
        """Return whether the lower limit equals the upper one, so that the joint is held there."""
        return self.type in LIMITED and not self.mistakes and self.limits[0] == self.limits[1]

    @property
    def moves(self) -> bool:
        """Return whether the joint turns or slides, or a loop moves it in several directions."""
        return (self.type in MOVING and not self.locked) or self.is_held_by_loops

    @property
    def is_held_by_loops(self) -> bool:
        """Return whether it has several freedoms, and loops lead through it."""
        return self.in_loop and self.type in _IN_LOOPS

    @property
    def path(self) -> str:
        """Return the element as an XPath."""
        return f'{self.root}/joint[@name="{self.name}"]'


@dataclass
class UrdfTree:
    """All links and joints by name, the mistakes found so far, and notes on what was repaired.

    format  as it is called in messages
    root    the root element as an XPath
    hinge   an example of a joint that moves
    drive   what says that a drive moves a joint of a loop
    tips    links that a file beside it names as tools
    loops   constraints between two links each
    """

    file: str
    name: str = ""
    format: str = "URDF"
    root: str = "/robot"
    hinge: str = '<joint name="A" type="revolute">'
    drive: str = "an <actuator> for each drive"
    tips: NamedTips | None = None
    notes: list[str] = field(default_factory=list)
    links: dict[str, UrdfLink] = field(default_factory=dict)
    joints: dict[str, UrdfJoint] = field(default_factory=dict)
    mistakes: list[Problem] = field(default_factory=list)
    loops: list[UrdfLoop] = field(default_factory=list)
    _children: dict[str, list[UrdfJoint]] = field(default_factory=dict)
    _parent: dict[str, UrdfJoint] = field(default_factory=dict)

    def refuse(self, line: int, path: str, *words: str) -> None:
        """Note a mistake: what was found, what is expected, an example, and the nearest name."""
        if not self.full:
            self.mistakes.append(
                Problem(f"{self.file}:{line}" if line else self.file, path, *words)
            )

    @property
    def full(self) -> bool:
        """Return whether more mistakes are known than will be listed: no need to look for
        others.
        """
        return len(self.mistakes) > MOST_MISTAKES

    def children(self, link: str) -> list[UrdfJoint]:
        """Return the joints that lead away from this link."""
        return self._children.get(link, [])

    @property
    def roots(self) -> list[str]:
        """Return the links without a parent."""
        return [name for name in self.links if name not in self._parent]

    def path_to(self, link: str, base: str | None = None) -> list[UrdfJoint] | None:
        """Return the joints from the base (the root unless stated) to this link. None where the
        base does not lead there.
        """
        out = []
        while link in self._parent and link != base:
            out.append(self._parent[link])
            link = out[-1].parent
        return out[::-1] if base in (None, link) else None

    def connect(self) -> None:
        """Hang every joint between its links; note links that do not exist, second parents, several
        roots, loops.
        """
        lost, before = False, len(self.mistakes)
        for joint in self.joints.values():
            for end, link in (("parent", joint.parent), ("child", joint.child)):
                if self.full:
                    return
                if link not in self.links:
                    lost = True
                    near = nearest(link, self.links)
                    known = near or next(iter(self.links), "base_link")
                    self.refuse(
                        joint.line,
                        f"{joint.path}/{end}/@link",
                        shown(link),
                        "the name of a link of this file",
                        f'<{end} link="{known}"/>',
                        near,
                    )
            if joint.child in self._parent:
                other = self._parent[joint.child].name
                found = f"a second parent of link '{joint.child}', beside joint '{other}'"
                self.refuse(
                    joint.line,
                    f"{joint.path}/child",
                    found,
                    "one parent for every link",
                    '<child link="another_link"/>',
                )
                continue
            self._parent[joint.child] = joint
            self._children.setdefault(joint.parent, []).append(joint)
        if not lost:
            self._check_whole()
        if len(self.mistakes) == before:
            self.loops = [loop for loop in self.loops if self._leads_through(loop)]

    def _leads_through(self, loop: UrdfLoop) -> bool:
        """Mark the joints of a loop. Return False where it only welds a free root to the world,
        which then stands where the file has it.
        """
        ways = [self.path_to(link) or [] for link in loop.links]
        names = {joint.name for joint in ways[0]} ^ {joint.name for joint in ways[1]}
        around = [self.joints[name] for name in names]
        moved = [joint.type for joint in around if joint.type != "fixed"]
        if moved == ["floating"] and not loop.turns:
            return False
        for joint in around:
            joint.in_loop = True
            if joint.is_held_by_loops:
                joint.other_mistakes.clear()
        return True

    def _check_whole(self) -> None:
        roots = self.roots
        if len(roots) > 1:
            found = f"{len(roots)} links without a parent: {listed(roots)}"
            example = (
                f'<joint name="mount" type="fixed"><parent link="{roots[0]}"/><child '
                f'link="{roots[1]}"/></joint>'
            )
            self.refuse(0, self.root, found, "one root link", example)
        reached = set(roots)
        waiting = list(roots)
        while waiting:
            for joint in self.children(waiting.pop()):
                reached.add(joint.child)
                waiting.append(joint.child)
        if len(reached) < len(self.links):
            around = [joint.name for joint in self.joints.values() if joint.child not in reached]
            first = self.joints[around[0]]
            found = f"joints that lead round in a loop: {listed(around)}"
            self.refuse(
                first.line,
                first.path,
                found,
                "a tree: every link reached from one root",
                '<parent link="base_link"/>',
            )


def is_name(text: str) -> bool:
    """Return whether this may name a link or a joint: one line of printable text that is not too
    long.
    """
    return text.isprintable() and len(text) <= LONGEST_NAME


def free_name(name: str, taken: Collection[str], kind: str) -> str:
    """Return a name that is not taken yet: this one, or with what it is behind it."""
    while name in taken:
        name = f"{name}_{kind}"
    return name
