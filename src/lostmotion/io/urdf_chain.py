"""The chain of a URDF that is studied: from the root, or the sidecar's `base`, to the tool."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final, NoReturn

from lostmotion.errors import Problem, shown
from lostmotion.io.limits import listed, nearest, refuse_all
from lostmotion.io.toml import quoted
from lostmotion.io.urdf_tip import Choice, choose_named_tip, choose_tip, listed_ends
from lostmotion.mechanism.arm import MOST_JOINTS

if TYPE_CHECKING:
    from lostmotion.io.urdf_tree import UrdfJoint, UrdfTree

_FREE: Final = ("floating", "planar")
_MOST_OTHERS: Final = 4
# A slide of so many metres, and of so many times the length of what it carries, is rather a cart on
# a floor than a joint of an arm.
_FAR: Final = 5.0
_FARTHER: Final = 3.0
_ALL_ROUND: Final = 2 * math.pi - 0.1


@dataclass(frozen=True)
class Chain:
    """The joints from base to tool, those before the base, notes on them, and warnings."""

    base: str
    tip: str
    joints: list[UrdfJoint]
    before: list[UrdfJoint]
    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def find_chain(tree: UrdfTree, content: dict[str, Any], sidecar: str, sidecar_name: str) -> Chain:
    """Return the chain of joints that is the arm.

    Parameters
    ----------
    tree
        The links and joints of the file.
    content
        The sidecar, of which `tip` and the name of the link in `base` are taken out.
    sidecar, sidecar_name
        The file that these mistakes stand in, and the name of the one that should be written.

    Raises
    ------
    InputError
        With every mistake: links that do not exist, several arms and no choice stated, joints on
        the chain that no serial arm has. An example `tip = "..."` leads to a chain that is read.

    """
    base = _base(tree, content, sidecar)
    tip = content.pop("tip", None)
    notes: list[str] = []
    warnings: list[str] = []
    if tip is None:
        choice = _chosen(tree, base, sidecar_name)
        tip = choice.link
        notes.append(_taken(choice))
        if not choice.by_name:
            warnings.append(
                f"the tool is a guess: link '{tip}' ends the longest chain, and no link has a "
                f"tool's name; tip in {sidecar_name} sets it"
            )
    elif not isinstance(tip, str) or tip not in tree.links or tree.path_to(tip, base) is None:
        near = nearest(str(tip), [link for link in tree.links if _reads(tree, base, link)])
        expected = f"the name of a link of {tree.file}" + (
            f" behind the base '{base}'" if base not in tree.roots else ""
        )
        _refuse(
            tree,
            sidecar,
            "tip",
            shown(tip),
            expected,
            f"tip = {quoted(near or _readable_tip(tree, base) or next(iter(tree.links)))}",
            near,
        )
    joints = tree.path_to(tip, base) or []
    tree.mistakes += _faults(tree, joints, base, tip)
    if tree.mistakes:
        refuse_all(tree.mistakes)
    cart = _cart(tree, joints, tip)
    if cart:
        far = [
            joint.name for joint in joints if joint.type == "prismatic" and _is_far(joint, joints)
        ]
        hint = f"base = {quoted(cart)} in {sidecar_name} starts the arm on it"
        warnings.append(
            f"{listed(far)} slides far: a cart? Its range is taken as the arm's; {hint}"
        )
    before = tree.path_to(base) or []
    held = [joint.name for joint in before if joint.type != "fixed"]
    if before:
        notes.append(
            f"the chain starts at link '{base}'"
            + (f"; {listed(held)} before it held at zero" if held else "")
        )
    notes += [
        f"joint '{joint.name}' ({joint.type}) carries the whole arm: it is held at zero"
        for joint in joints
        if _is_free(joint)
    ]
    notes += [
        f"joint '{joint.name}' cannot move, for its lower limit is its upper one: it is fixed there"
        for joint in joints
        if joint.locked
    ]
    return Chain(base, tip, joints, before, notes, warnings)


def _base(tree: UrdfTree, content: dict[str, Any], sidecar: str) -> str:
    """Take the link where the chain starts out of the sidecar: `base = "torso_link"`, or `link` in
    a table [base]; the root where none is named.
    """
    stated = content.get("base")
    key = "base"
    if isinstance(stated, dict):
        if "link" not in stated:
            return tree.roots[0]
        stated, key = stated.pop("link"), "base.link"
    elif stated is None:
        return tree.roots[0]
    else:
        content.pop("base")
    if not isinstance(stated, str) or stated not in tree.links:
        tip = content.get("tip")
        near = nearest(str(stated), (link for link in tree.links if _starts(tree, link, tip)))
        expected = f"the name of a link of {tree.file}, where the chain starts, or a table [base]"
        _refuse(
            tree,
            sidecar,
            key,
            shown(stated),
            expected,
            f"{key.rpartition('.')[2]} = {quoted(near or tree.roots[0])}",
            near,
        )
    return stated


def _refuse(tree: UrdfTree, *fields: str) -> NoReturn:
    refuse_all([*tree.mistakes, Problem(*fields)])


def _chosen(tree: UrdfTree, base: str, sidecar_name: str) -> Choice:
    """Return what is probably the tool."""
    choice = choose_tip(tree, base)
    choice = choose_named_tip(tree, base, choice) or choice
    if choice is None:
        locked = [joint.name for joint in tree.joints.values() if joint.locked]
        found = "no joint that moves" + (
            f": the lower limit is the upper one at {listed(locked)}" if locked else ""
        )
        expected = "a chain with at least one revolute, continuous or prismatic joint" + (
            " and a range between its limits" if locked else ""
        )
        example = (
            '<limit lower="-1.57" upper="1.57" effort="0" velocity="0"/>' if locked else tree.hinge
        )
        _refuse(tree, tree.file, tree.root, found, expected, example)
    if choice.rivals:
        ends = [replace(choice, rivals=()), *choice.rivals]
        good = next((end.link for end in ends if _reads(tree, base, end.link)), None)
        if good is not None:
            asked, wanted = (
                ("links of the loops carries the tool", "that link")
                if tree.loops
                else ("arms", "the one to study")
            )
            found = f"which of {len(ends)} {asked}? {listed(listed_ends(ends))}"
            expected = f"{wanted}, named in {sidecar_name}"
            _refuse(tree, tree.file, tree.root, found, expected, f"tip = {quoted(good)}")
    return choice


def _taken(choice: Choice) -> str:
    """Write what was taken as the tool, and what it could be as well."""
    how = (
        f"named in {choice.file}"
        if choice.file
        else "by its name"
        if choice.by_name
        else "a guess by the structure"
    )
    others = f"others: {listed(choice.others[:_MOST_OTHERS])}; " if choice.others else ""
    joints = f"{choice.joints} joint{'s' * (choice.joints != 1)}"
    return f'tool: {choice.link}, {joints} ({how}; {others}tip = "..." changes it)'


def _faults(tree: UrdfTree, joints: list[UrdfJoint], base: str, tip: str) -> list[Problem]:
    """Return what keeps these joints from being a serial arm."""
    out: list[Problem] = []
    moved = False
    cart = _cart(tree, joints, tip)
    for joint in joints:
        at = (f"{tree.file}:{joint.line}" if joint.line else tree.file, joint.path)
        out += (
            [_with_base(mistake, cart) for mistake in joint.limit_mistakes]
            if cart
            else joint.limit_mistakes
        )
        out += joint.other_mistakes
        if _is_free(joint) and moved:
            expected = "revolute, continuous, prismatic or fixed joints between base and tip"
            out.append(Problem(*at, f"a {joint.type} joint", expected, tree.hinge))
        if joint.moves and joint.leader:
            out.append(_coupled(tree, joint, base, at, moved=moved))
        moved = moved or joint.moves
    if len(joints) > MOST_JOINTS:
        out.append(
            Problem(
                tree.file,
                tree.root,
                f"{len(joints)} joints between base and tip",
                f"at most {MOST_JOINTS}",
                f"tip = {quoted(joints[6].child)}",
            )
        )
    if not moved and not out:
        better = _readable_tip(tree, base)
        example = f"tip = {quoted(better)}" if better else tree.hinge
        found = f"no joint that moves before the tip '{tip}'"
        expected = "a tip behind at least one moving joint"
        free = [joint.name for joint in joints if joint.type in _FREE]
        if free:
            found += f", only {listed(free)}, which no loop holds"
            expected += ", or legs that close loops with what it carries"
        out.append(Problem(tree.file, tree.root, found, expected, example))
    return out


def _is_free(joint: UrdfJoint) -> bool:
    """Return whether nothing holds what a joint carries."""
    return joint.type in _FREE and not joint.is_held_by_loops


def _coupled(
    tree: UrdfTree, joint: UrdfJoint, base: str, at: tuple[str, str], *, moved: bool
) -> Problem:
    found = (
        f"joint '{joint.name}' follows '{joint.leader}' ({joint.coupling}): a linkage on the way "
        "to the tool"
    )
    # a constraint between two bodies, which MJCF has, is a loop and does not lead here
    expected = (
        "joints with drives of their own: that states a ratio, not a mechanism, whose pins and "
        "rods have errors; state a four-bar by its pins as passive joints, and [[closures]]"
    )
    before = joint.parent if moved and _reads(tree, base, joint.parent) else ""
    if before:
        expected += f"; a tip before it, {before}, would do"
        return Problem(*at, found, expected, f"tip = {quoted(before)}")
    return Problem(*at, found, expected, '[[closures]] with joins = ["rod.tip", "forearm.tip"]')


def _with_base(mistake: Problem, cart: str) -> Problem:
    """Return the mistake in the limits of a slide that may be a cart's, with the line that starts
    the arm on the cart.
    """
    expected = f"{mistake.expected}; or, if it is a cart's, a base behind it, {cart}"
    return replace(mistake, expected=expected, example=f"base = {quoted(cart)}")


def _cart(tree: UrdfTree, joints: list[UrdfJoint], tip: str) -> str:
    """Return the link of the cart that carries the arm; empty where the first joint that moves is
    no slide of a cart.

    Such a slide has no range, or a far one. Slides and full turns behind it belong to it as long as
    nothing between them has a mass.
    """
    cart = ""
    for joint in (each for each in joints if each.moves):
        slides = joint.type == "prismatic" and (
            bool(joint.limit_mistakes) or _is_far(joint, joints)
        )
        turns = bool(cart) and (
            joint.type == "continuous"
            or (joint.type == "revolute" and joint.limits[1] - joint.limits[0] >= _ALL_ROUND)
        )
        if not slides and not turns:
            break
        cart = joint.child
        if tree.links[cart].mass:
            break
    return cart if cart and _reads(tree, cart, tip) else ""


def _is_far(joint: UrdfJoint, joints: list[UrdfJoint]) -> bool:
    """Return whether a joint slides over a way that no arm behind it compares with."""
    carried = math.fsum(math.hypot(*each.xyz) for each in joints[joints.index(joint) + 1 :])
    return joint.limits[1] - joint.limits[0] > max(_FAR, _FARTHER * carried)


def _starts(tree: UrdfTree, base: str, tip: object) -> bool:
    """Return whether the chain from a link to a tip is a serial arm; without a tip, whether
    something moves behind the link.
    """
    if isinstance(tip, str) and tip in tree.links:
        return _reads(tree, base, tip)
    return any(_reads(tree, base, link) for link in _behind(tree, base))


def _behind(tree: UrdfTree, base: str) -> list[str]:
    """Return the links behind this one as far as the first joints that move."""
    out: list[str] = []
    waiting = [base]
    while waiting:
        for joint in tree.children(waiting.pop()):
            out.append(joint.child)
            if not joint.moves:
                waiting.append(joint.child)
    return out


def _reads(tree: UrdfTree, base: str, tip: str) -> bool:
    """Return whether the chain to this link is a serial arm, so that a hint may name it."""
    joints = tree.path_to(tip, base)
    if not joints or len(joints) > MOST_JOINTS or not any(joint.moves for joint in joints):
        return False
    moved = False
    for joint in joints:
        if joint.mistakes or (_is_free(joint) and moved) or (joint.moves and joint.leader):
            return False
        moved = moved or joint.moves
    return True


def _readable_tip(tree: UrdfTree, base: str) -> str | None:
    """Return the best link whose chain is a serial arm, None where there is none."""
    choice = choose_tip(tree, base)
    if choice is not None and _reads(tree, base, choice.link):
        return choice.link
    readable = [link for link in tree.links if _reads(tree, base, link)]
    return max(
        readable,
        key=lambda link: sum(joint.moves for joint in tree.path_to(link, base) or []),
        default=None,
    )
