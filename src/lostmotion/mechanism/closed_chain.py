"""Closed chains: whether the closures of an arm can be met, where they are met, and what they
carry.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.errors import InputError, Problem, nearest, shown
from lostmotion.mechanism.closed_arrays import ASSEMBLED, SINGULAR
from lostmotion.mechanism.closed_home import holds_drives, home_of, nearby_rank, rank_of
from lostmotion.mechanism.closed_jacobian import balance, loop_columns, signs, size, tool_columns
from lostmotion.mechanism.closed_position import (
    LIMITED,
    NEAR_SINGULAR,
    assemble,
    joint_value,
)
from lostmotion.mechanism.settled_loops import settled_loops

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.mechanism.closed_position import Assembly
    from lostmotion.mechanism.closed_statics import Loops, Spring
    from lostmotion.mechanism.closures import Closure
    from lostmotion.mechanism.opened_constraints import Way
    from lostmotion.mechanism.places import Tree
    from lostmotion.parts.joint import Joint
    from lostmotion.spatial import Floats

_ENDS: Final = (".seat", "", ".tip")
# A tool that moves less per unit of an idle freedom (rad, or share of the size) stands still.
_STILL: Final = 1e-4
# A hinge that stands farther from its stated start is in another assembly mode, rad.
_FAR_FROM_START: Final = math.pi / 2
# Examples of the start of a passive joint, by the number of its freedoms.
_STARTS: Final = {
    2: 'start = ["10 deg", "-77 deg"]',
    3: 'start = ["0 deg", "10 deg", "-77 deg"]',
    6: 'start = { xyz = ["0 mm", "0 mm", "75 mm"] }',
}
# What mends a chain whose closures hold its drives, and an example.
_FEWER_DRIVES: Final = (
    "a passive joint more in the loop of these drives, or a drive less",
    "passive = true",
)


class Mistake(NamedTuple):
    """A mistake in the closures of an arm: path of its key, what a message states, and the name
    that was probably meant.
    """

    path: tuple[str | int, ...]
    found: str
    expected: str
    example: str
    near: str = ""


def closing_error(joints: Sequence[Joint], closures: Sequence[Closure]) -> Mistake | None:
    """Return the first mistake in what closures join; None without one. Every `after` must name an
    earlier place.
    """
    known = ["base", *(f"{joint.name}{end}" for joint in joints for end in _ENDS)]
    for k, closure in enumerate(closures):
        strange = [name for name in closure.joins if known.count(name) != 1]
        if strange:
            near = nearest(strange[0], known)
            joined = [each for each in closure.joins if each not in strange] or [known[3]]
            return Mistake(
                ("closures", k, "joins"),
                shown(strange[0]),
                "two places: base, or NAME.seat, NAME or NAME.tip of a joint",
                f'joins = ["{joined[0]}", "{near or known[-1]}"]',
                near,
            )
    if closures:
        return None
    passive = [
        (k, "passive") for k, joint in enumerate(joints) if joint.type != "fixed" and joint.passive
    ]
    started = [
        (k, "start") for k, joint in enumerate(joints) if getattr(joint, "start", None) is not None
    ]
    for k, key in (*passive, *started):
        return Mistake(
            ("joints", k, key),
            f"{key} of a joint of an arm without closures",
            "a joint with a drive, or a closure that moves it",
            '[[closures]] with joins = ["A.tip", "B.tip"]',
        )
    return None


def assembly_error(joints: Sequence[Joint], tree: Tree) -> Mistake | None:
    """Return the first mistake in how the closures of a tree constrain it; None without one."""
    return _branch_error(joints, tree) or _home_error(joints, tree) or _freedom_error(tree)


def _branch_error(joints: Sequence[Joint], tree: Tree) -> Mistake | None:
    for k, weld in enumerate(tree.welds):
        low, high = sorted(weld.places)
        if low and low in tree.inboard(high):
            names = [tree.places[place].name for place in weld.places]
            return Mistake(
                ("closures", k, "joins"),
                f"{names[0]} and {names[1]} on one branch: one carries the other",
                "two places on different branches",
                'joins = ["A.tip", "B.tip"]',
            )
    held = np.asarray(signs(tree).any(axis=0))
    for each in tree.passive:
        if not held[each.place]:
            index = next(k for k, joint in enumerate(joints) if joint.name == each.joint)
            return Mistake(
                ("joints", index, "passive"),
                f"the passive joint {each.joint} in no loop: no closure moves it",
                "a joint with a drive, or a closure that joins what it carries to another branch",
                '[[closures]] with joins = ["A.tip", "B.tip"]',
            )
    return None


def _home_error(joints: Sequence[Joint], tree: Tree) -> Mistake | None:
    home = home_of(tree)
    if not home.met:
        worst = int(np.nan_to_num(home.misfit, nan=np.inf).max(axis=1).argmax())
        turn, shift = (home.misfit[worst] * np.array([1.0, size(tree)])).tolist()
        names = [tree.places[place].name for place in tree.welds[worst].places]
        apart = (
            f"{names[0]} and {names[1]} apart at home by {_by(1e3 * shift)} mm and "
            f"{_by(math.degrees(turn))} deg at least"
        )
        counted, left, held = _count(tree)
        if left < 0 and holds_drives(tree):
            few = "1 freedom" if left == -1 else f"{-left} freedoms"
            return Mistake(
                ("closures", worst),
                f"{apart}; {counted}: {few} too few for {', '.join(held)}",
                *_FEWER_DRIVES,
            )
        return Mistake(
            ("closures", worst),
            apart,
            "a loop that closes with the drives at home: lengths, axes and limits of the drives, "
            "and start of the passive joints near where they stand there",
            _start(tree),
        )
    if home.crossed:
        names = [each.joint for each in tree.passive]
        return Mistake(
            ("closures",),
            "a start in another assembly mode: the way from it to the closed loops leads through a "
            "singularity",
            f"start of the passive joints {', '.join(dict.fromkeys(names))} near where they stand "
            "with the drives at home",
            _start(tree),
        )
    return _misled(joints, tree) or _limited(tree)


def _misled(joints: Sequence[Joint], tree: Tree) -> Mistake | None:
    """Return the mistake of a hinge that stands far from its stated start at home."""
    home = home_of(tree)
    for each, (motion,) in zip(tree.passive, home.motions, strict=True):
        twist = tree.places[each.place].twist
        if twist.shape[1] > 1 or not twist[:3].any() or np.array_equal(each.start, np.eye(4)):
            continue
        start, stands = (joint_value(twist[:, 0], of[None])[0] for of in (each.start, motion))
        if abs(np.angle(np.exp(1j * (stands - start)))) > _FAR_FROM_START:
            names = [joint.name for joint in joints]
            return Mistake(
                ("joints", names.index(each.joint), "start"),
                f"{each.joint} at {math.degrees(stands):.4g} deg at home, with its start at "
                f"{math.degrees(start):.4g} deg: another assembly mode",
                "start of each passive joint within 90 deg of where it stands with the drives at "
                "home, in the mode that is wanted",
                f'start = "{math.degrees(stands):.4g} deg"',
            )
    return None


def _limited(tree: Tree) -> Mistake | None:
    """Return the mistake of a passive joint outside its limits at home."""
    found = assemble(tree, np.array(tree.home)[None])
    if found.problem[0] != LIMITED:
        return None
    return Mistake(
        ("closures",),
        f"the passive joint {tree.passive[int(found.joint[0])].joint} outside its limits at home",
        "limits that contain its value at home, or a start in the other assembly mode",
        _start(tree, int(found.joint[0])),
    )


def _by(length_or_angle: float) -> str:
    """Write how far apart two places are; what rounding leaves is 0."""
    return f"{round(length_or_angle, 9):.4g}"


def _start(tree: Tree, passive: int = 0) -> str:
    """Return an example of the start of a passive joint, in the form that a joint of its kind
    takes.
    """
    twist = tree.places[tree.passive[passive].place].twist
    if twist.shape[1] == 1:
        return 'start = "-77 deg"' if twist[:3].any() else 'start = "120 mm"'
    return _STARTS[twist.shape[1]]


def _count(tree: Tree) -> tuple[str, int, list[str]]:
    """Return the count of the freedoms of a chain at home in words, the freedoms that are left to
    the drives beyond their number, and the drives that closures hold.
    """
    home, at = home_of(tree), home_frames(tree)
    rows, _ = balance(tree)
    driven = loop_columns(tree, at, list(tree.moved))[0] * rows[:, None]
    passive = home.jacobian[0]
    drives, freedoms = driven.shape[1], driven.shape[1] + passive.shape[1]
    rank = rank_of(np.concatenate([driven, passive], axis=1))
    counted = (
        f"{freedoms} freedoms - rank {rank} of the closures = {freedoms - rank}, for {drives} "
        f"{'drive' if drives == 1 else 'drives'}"
    )
    held = [
        tree.places[place].name
        for place, column in zip(tree.moved, driven.T, strict=True)
        if rank_of(np.column_stack([passive, column])) > home.rank
    ]
    return counted, freedoms - rank - home.idle - drives, held


def _freedom_error(tree: Tree) -> Mistake | None:
    """Return the mistake of a chain with one freedom too many or too few, or singular at home."""
    home, (counted, left, held) = home_of(tree), _count(tree)
    loose = _loose(tree) if home.idle else []
    if (loose or left < 0) and nearby_rank(tree) > home.rank:
        return Mistake(
            ("closures",),
            "a home in a parallel singularity: the tool is loose with all drives held",
            "a home away from it: start of the drives",
            'start = "30 deg"',
        )
    if loose and left < 0:
        return Mistake(
            ("closures",),
            "a shape that is singular at home and beside it: the tool is loose with all drives "
            f"held, by {loose[0]} and {len(loose) - 1} more passive joints",
            "another shape: a platform similar to its base, for example, is loose at every pose",
            'end = { xyz = ["64.7 mm", "241.5 mm", "0 mm"] }',
        )
    if left < 0:
        return Mistake(
            ("closures",),
            f"{counted}: the closures hold {', '.join(held)}",
            *_FEWER_DRIVES,
        )
    if not loose:
        return None
    return Mistake(
        ("closures",),
        f"{counted}: the tool is loose by {', '.join(loose)}",
        "a passive joint less in this loop, another closure, or a drive more",
        'gearbox = { backlash = "1 arcmin" }',
    )


def _loose(tree: Tree) -> list[str]:
    """Return the names of the passive joints that move the tool with all drives held."""
    home = home_of(tree)
    vectors = np.linalg.svd(home.jacobian[0])[2][home.rank :]
    moved = tool_columns(tree, home_frames(tree))[0] @ vectors.T
    if np.abs(moved).max(initial=0.0) <= _STILL:
        return []
    turned, names, first = np.abs(vectors).max(axis=0), [], 0
    for each in tree.passive:
        last = first + tree.places[each.place].twist.shape[1]
        names += [each.joint] if turned[first:last].max() > _STILL else []
        first = last
    return list(dict.fromkeys(names))


def home_frames(tree: Tree) -> Floats:
    """Return the frames (place, 1, 4, 4) of a chain at home."""
    return assemble(tree, np.array(tree.home)[None]).frames


def assembly_of(tree: Tree, q: Floats) -> Assembly | None:
    """Return the chain at these values of the driven joints (pose, joint); None for one without
    closures.
    """
    return assemble(tree, q) if tree.welds else None


def assembled_frames(tree: Tree, q: Floats) -> Floats:
    """Return the frames of the places of a closed chain (place, pose, 4, 4), m. Raises InputError
    for a pose at which it is not assembled.
    """
    found = assemble(tree, q)
    bad = np.flatnonzero((found.problem != ASSEMBLED) & (found.problem != NEAR_SINGULAR))
    if len(bad):
        first = int(bad[0])
        raise InputError(
            [
                Problem(
                    "",
                    "pose",
                    f"pose {first} of {len(q)}: {problem_text(tree, found, first)}"
                    + (f"; so are {len(bad) - 1} more" if len(bad) > 1 else ""),
                    "poses at which the closed chain is assembled in the mode of its home",
                )
            ]
        )
    return found.frames


def problem_text(tree: Tree, assembly: Assembly, pose: int) -> str:
    """Return why a chain is not assembled at a pose."""
    problem = assembly.problem[pose]
    if problem == LIMITED:
        name = tree.passive[int(assembly.joint[pose])].joint
        return f"the passive joint {name} is outside its limits"
    if problem == SINGULAR:
        return "it lies beyond a parallel singularity of the closed chain"
    return "the closed chain cannot be assembled there"


def refuse_closed(tree: Tree, what: str, instead: str) -> None:
    """Raise InputError where an arm has closures: there is no `what` of it, but `instead` there
    is.
    """
    if tree.welds:
        raise InputError([Problem("", "closures", f"a closed chain, which has no {what}", instead)])


def closed_statics(
    tree: Tree,
    at: Floats,
    of_tree: Floats,
    springs: Callable[[Floats], Sequence[Spring]],
    open_ways: Sequence[Way] = (),
) -> tuple[Loops, Floats]:
    """Return the closures of a closed chain and the wrenches on its places (`settled_loops`)."""
    return settled_loops(tree, at, of_tree, springs, open_ways, exact=is_exact(tree))


def is_exact(tree: Tree) -> bool:
    """Return whether the closures determine the passive joints exactly: none is redundant, and no
    freedom is idle.
    """
    home = home_of(tree)
    return (home.rank, home.rank) == home.jacobian.shape[1:]


def taken_up(tree: Tree, loops: Loops, place: int, local: Floats) -> None:
    """Raise InputError where twists at a place, local (6, term, pose), have no answer because loops
    of rigid parts cannot take them up.
    """
    if not loops.refuses(place, local).any():
        return
    rows = np.flatnonzero(signs(tree)[:, place])
    names = ", ".join(
        " and ".join(tree.places[k].name for k in tree.welds[row].places) for row in rows
    )
    raise InputError(
        [
            Problem(
                "",
                tree.places[place].name,
                f"an error at {tree.places[place].name} that the loop closed between {names} "
                "cannot take up: its parts are rigid, and more than enough constrain it",
                "a spring in this loop: a section of a link, a stiffness of a bearing, or a joint "
                "with more freedoms (spherical)",
                'link = { length = "400 mm", section = "tube", material = "steel" }',
            )
        ]
    )
