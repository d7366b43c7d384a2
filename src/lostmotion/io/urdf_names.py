"""Meaning of the names of a URDF's links and joints: fingers, balancers, sides, flanges and tool
points.
"""

from __future__ import annotations

import re
from typing import Final

# Names of tools, best first: whole words between `_`, `-`, `/` and the ends, in any case, with free
# prefixes.
RANKS: Final = tuple(
    re.compile(rf"(?:^|_)(?:{words})(?:_|$)")
    for words in (
        "tcp|tool_cent(?:er|re)_point",
        "grasp[a-z]*|pinch|gripper_frame|gripper_cent(?:er|re)|ee_gripper",
        "tool[0-9]*|tool_?frame",
        "ee|eef|end_?effector|effector",
        "flange|attachment",
        "(?:hand|palm|gripper_base|gripper_(?:left|right)_base)(?:_(?:link|frame|base|base_link))?$",
        "gripper(?:_(?:link|stator|body))?$",
    )
)
FINGERS: Final = re.compile(
    r"finger|knuckle|thumb|pinky|jaw|(?:^|_)(?:index|pads?|inner|driver)(?:_|$)|gripper_?(?:[lr]_|left_|right_)?joint"
)
GRIPPER: Final = re.compile(r"gripper")
WRIST: Final = re.compile(r"wrist|roll|pitch|yaw|rotat|swivel")
BODY: Final = re.compile(r"wheel|cast[eo]r|(?:^|_)(?:head|neck|ankle|knee|hip|foot|legs?)(?:_|$)")
BALANCER: Final = re.compile(r"cylinder|piston|balanc")
ASIDE: Final = re.compile(
    r"camera|realsense|(?:^|_)(?:cam|imu|optical|ft|laser|lidar|sensors?|dummy|covers?|cables?|inertia|collisions?|sc)(?:_|$)"
)
# So many moving joints make an arm; fewer behind a sensor or a cover belong to that.
ARM: Final = 3
_SIDES: Final = (("left", "right"), ("l", "r"), ("1", "2"))


def is_balancer(name: str) -> bool:
    """Return whether this is the name of a balancing cylinder or spring."""
    return bool(BALANCER.search(words_of(name)))


def words_of(name: str) -> str:
    """Write a name in small letters with `_` between its words."""
    return re.sub(r"[^a-z0-9]+", "_", re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()).strip(
        "_"
    )


def rank_of(link: str) -> int:
    """Return how well a link's name says that it is a tool, 0 best; the number of ranks where it
    does not.
    """
    words = words_of(link)
    if ASIDE.search(words) or FINGERS.search(words):
        return len(RANKS)
    return next((rank for rank, known in enumerate(RANKS) if known.search(words)), len(RANKS))


def mirrored(one: str, other: str) -> bool:
    """Return whether names differ by left and right, l and r, or 1 and 2 only."""
    if one == other:
        return False
    a, b = (re.split(r"_|(?<=[a-z])(?=[0-9]+$)", words_of(name)) for name in (one, other))
    return len(a) == len(b) and all(x == y or _is_pair(x, y) for x, y in zip(a, b, strict=True))


def _is_pair(one: str, other: str) -> bool:
    return any({one, other} == set(pair) for pair in _SIDES)


def side_of(link: str) -> str:
    """Return the side of the arm that a link's name states, "left: " or "right: "; else nothing."""
    sides = {"left": "left: ", "l": "left: ", "right": "right: ", "r": "right: "}
    return next((sides[word] for word in words_of(link).split("_") if word in sides), "")
