"""What makes a URDF's numbers doubtful: no masses, the same ones everywhere, lengths in
millimetres, ranges that nobody measured.

Such files are read, for kinematics may be right all the same; a warning is shown.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from lostmotion.io.limits import cut, listed
from lostmotion.io.urdf_names import is_balancer
from lostmotion.mechanism.arm import LONGEST_NOTE
from lostmotion.parts.joint import FixedJoint, RevoluteJoint

if TYPE_CHECKING:
    from lostmotion.io.urdf_chain import Chain
    from lostmotion.io.urdf_tree import UrdfJoint, UrdfLink, UrdfTree
    from lostmotion.mechanism.arm import Arm

_LIGHTEST: Final = 1e-3  # kg
_HEAVIEST: Final = 2000.0  # kg
_SHORTEST: Final = 0.05  # m
_LONGEST: Final = 15.0  # m
_SEVERAL: Final = 3
# A little more than two turns, for limits that are rounded.
_TWO_TURNS: Final = 4 * math.pi * 1.01


def with_warnings(arm: Arm, tree: UrdfTree, chain: Chain) -> Arm:
    """Return the arm with a warning for everything in its URDF that looks like a placeholder, and
    for a tool that is a guess.
    """
    found = [
        *_of_masses(arm, tree, chain),
        *_of_lengths(chain),
        *_of_ranges(arm, tree),
        *chain.warnings,
    ]
    return arm.with_warnings(cut(text, LONGEST_NOTE) for text in found) if found else arm


def _of_masses(arm: Arm, tree: UrdfTree, chain: Chain) -> list[str]:
    masses = [joint.total_mass + joint.link.total_mass for joint in arm.joints]
    total = sum(masses)
    if total == 0:
        lack = (
            "no link of this arm has a mass: what its own weight does to it (sag, wind-up, drive "
            "torques) is missing"
        )
        return [
            (
                f"{lack}; state masses in the sidecar, for example [joints.NAME] with link = {{ "
                f'mass = "2 kg" }}'
            )
        ]
    out = []
    if not _LIGHTEST <= total <= _HEAVIEST:
        out.append(f"the arm weighs {total:.3g} kg: are the masses in kg?")
    weightless = _weightless(arm, masses)
    if weightless:
        out.append(
            f"nothing that moves with {listed(weightless)} alone has a mass: is it missing in "
            f"the {tree.format}?"
        )
    bodies = [(joint, link) for joint in chain.joints if (link := tree.links[joint.child]).mass]
    several = len(bodies) >= _SEVERAL
    if several and len({link.mass for _, link in bodies}) == 1:
        out += _placeholders(bodies, "mass", "every link weighs", f"{bodies[0][1].mass:g} kg")
    if several and not any(any(link.centre) for _, link in bodies):
        out += _placeholders(
            bodies, "centre_of_mass", "every centre of mass lies at", "its link's origin"
        )
    if any(
        is_balancer(name)
        for joint in tree.joints.values()
        if joint.moves
        for name in (joint.name, joint.child)
    ):
        out.append(
            f"springs and balancers are not in a {tree.format}: shoulder torques may be overstated"
        )
    return out


def _placeholders(
    bodies: list[tuple[UrdfJoint, UrdfLink]], key: str, words: str, what: str
) -> list[str]:
    """Return the doubt about values that are the same everywhere; none where the sidecar states
    them all.
    """
    left = [joint.name for joint, _ in bodies if key not in joint.repaired]
    if not left:
        return []
    still = (
        "" if len(left) == len(bodies) else f"; the sidecar does not state those of {listed(left)}"
    )
    return [f"{words} {what}{still}: placeholders? Torques and sag are then no better than a guess"]


def _weightless(arm: Arm, masses: list[float]) -> list[str]:
    """Name the moving joints of which nothing up to the next one weighs anything."""
    out: list[str] = []
    weight = 0.0
    for joint, mass in zip(reversed(arm.joints), reversed(masses), strict=True):
        weight += mass
        if not isinstance(joint, FixedJoint):
            if not weight and not joint.passive:  # pins of loops may weigh nothing
                out.append(joint.name)
            weight = 0.0
    return out[::-1]


def _of_lengths(chain: Chain) -> list[str]:
    length = math.fsum(math.hypot(*joint.xyz) for joint in chain.joints)
    if _SHORTEST <= length <= _LONGEST:
        return []
    return [
        (
            f"the origins from base to tool add up to {float(f'{length:.3g}'):.12g} m: are they in "
            "metres, or in millimetres?"
        )
    ]


def _of_ranges(arm: Arm, tree: UrdfTree) -> list[str]:
    far = [
        joint.name
        for joint in arm.driven
        if isinstance(joint, RevoluteJoint) and joint.limits[1] - joint.limits[0] > _TWO_TURNS
    ]
    return (
        [
            (
                f"{listed(far)} may turn more than twice around by the {tree.format}: poses are "
                "drawn from the whole range"
            )
        ]
        if far
        else []
    )
