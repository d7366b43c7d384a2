"""Find the tool link of a URDF. By names first, then by structure, as a person decides; never
between two arms.

Fingers, balancers, legs and wheels are set aside by their names, sliding pairs and joints that
follow others by their structure. Among the links that are left, behind three moving joints or more,
the name decides (`tcp` before `tool0` before `flange`); without one, the end of the longest chain.
"""

from __future__ import annotations

import re
from collections import defaultdict
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from lostmotion.io.urdf_names import (
    ARM,
    ASIDE,
    BALANCER,
    BODY,
    FINGERS,
    GRIPPER,
    RANKS,
    WRIST,
    mirrored,
    rank_of,
    side_of,
    words_of,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from lostmotion.io.urdf_tree import UrdfJoint, UrdfTree

# Ranks of frames, which stand beside a jaw on one link, before those of bodies.
_FRAMES: Final = 3
_LONGEST_TAIL: Final = 4
# So many joints behind one that follows another are the rest of an arm, and no gripper's second
# knuckle.
_FOLLOWED: Final = 2


@dataclass(frozen=True, slots=True)
class _LinkPlace:
    """A link in the tree: the moving joints on the way to it, and how many fixed ones came after
    the last of them.
    """

    link: str
    way: tuple[str, ...] = ()
    fixed: int = 0
    aside: bool = False
    coupled: bool = False
    depth: int = 0

    @property
    def end(self) -> str:
        return self.way[-1] if self.way else ""


@dataclass(frozen=True, slots=True)
class Choice:
    """The link that is probably the tool.

    by_name  its name says so, or a file; else the structure suggests it
    others   links that it could be as well, best first
    file     that names it
    rivals   ends of other arms that are as good: then nobody but the user can choose
    """

    link: str
    joints: int
    by_name: bool
    others: tuple[str, ...] = ()
    rivals: tuple[Choice, ...] = field(default=())
    file: str = ""


def choose_tip(tree: UrdfTree, base: str) -> Choice | None:
    """Return the link behind `base` that is probably the tool; None where no joint moves.

    A chain through a joint that follows another one is chosen only where nothing else moves, or
    where a tool's name stands behind it: the caller refuses it by name then, for an arm cut off
    before it would be another arm.
    """
    for sparing in (True, False):  # a gripper alone consists of fingers: then nothing is set aside
        spots = [
            spot for spot in _spots(tree, base, sparing=sparing) if spot.way and not spot.aside
        ]
        free = [spot for spot in spots if not spot.coupled]
        behind = _best(tree, spots)
        found = _best(tree, free)
        if found is not None and behind is not None and _goes_on(found, behind):
            return behind
        if found is not None or behind is not None:
            return found or behind
    return None


def choose_named_tip(tree: UrdfTree, base: str, choice: Choice | None) -> Choice | None:
    """Return the link that a file beside the description names as the tool, in place of a `choice`
    by names and structure.

    Of several on one way the best name, else the one that is named first. Of several arms those on
    the way to the choice count, where it has no rivals. None where nothing moves before a named
    link, or where the file does not decide between arms.
    """
    ways = {
        link: tuple(joint.name for joint in tree.path_to(link, base) or [] if joint.moves)
        for link in (tree.tips.links if tree.tips else ())
    }
    ways = {link: way for link, way in ways.items() if way}
    longest = max(ways.values(), key=len, default=())
    if any(way != longest[: len(way)] for way in ways.values()):
        if choice is None or choice.rivals:
            return None
        longest = tuple(
            joint.name for joint in tree.path_to(choice.link, base) or [] if joint.moves
        )
        ways = {
            link: way
            for link, way in ways.items()
            if _common(way, longest) == min(len(way), len(longest))
        }
    if not ways or tree.tips is None:
        return None
    best = min(ways, key=rank_of)
    return Choice(
        best,
        len(ways[best]),
        by_name=True,
        others=tuple(link for link in ways if link != best),
        file=tree.tips.file,
    )


def _goes_on(choice: Choice, behind: Choice) -> bool:
    """Return whether a tool is behind a coupled joint: by its name where none comes before it, or
    by several joints more.
    """
    return (behind.by_name and not choice.by_name) or behind.joints - choice.joints >= _FOLLOWED


def _spots(tree: UrdfTree, base: str, *, sparing: bool) -> Iterator[_LinkPlace]:
    """Walk the tree from its base, parents first and in the file's order."""
    depth = _depths(tree, base)
    waiting = [_LinkPlace(base)]
    while waiting:
        spot = waiting.pop()
        yield spot
        children = tree.children(spot.link)
        jaws = [joint.name for joint in children if _is_like_a_jaw(joint, spot, depth[joint.child])]
        has_tool = any(
            joint.type == "fixed" and rank_of(joint.child) <= _FRAMES for joint in children
        )
        for joint in reversed(children):
            beyond = replace(spot, link=joint.child, fixed=spot.fixed + 1, depth=spot.depth + 1)
            if joint.type in ("floating", "planar") and spot.way and not joint.moves:
                beyond = replace(beyond, aside=True)
            elif joint.moves or joint.mistakes:
                pair = len(jaws) > 1 and joint.name in jaws
                jaw = (
                    has_tool
                    and bool(GRIPPER.search(words_of(joint.child)))
                    and not WRIST.search(words_of(joint.name))
                )
                aside = spot.aside or (
                    sparing and (pair or jaw or _is_aside(joint, depth[joint.child]))
                )
                # a platform that legs carry moves as an arm of six joints
                freedoms = 6 if joint.type == "floating" else 1
                beyond = replace(
                    beyond,
                    way=(*spot.way, *[joint.name] * freedoms),
                    fixed=0,
                    aside=aside,
                    coupled=spot.coupled or bool(joint.leader) or joint.in_loop,
                )
            waiting.append(beyond)


def _is_like_a_jaw(joint: UrdfJoint, spot: _LinkPlace, beyond: int) -> bool:
    """Return whether a joint moves as one jaw of a pair does: it slides or follows another one, and
    nothing more moves behind it.

    One that follows a joint on the way to it is part of a linkage: jaws follow each other, or a
    drive beside them.
    """
    return (
        joint.moves
        and not beyond
        and (joint.leader not in spot.way if joint.leader else joint.type == "prismatic")
    )


def _depths(tree: UrdfTree, base: str) -> dict[str, int]:
    """Return how many joints move on the longest way out of each link."""
    order = [base]
    for link in order:
        order += [joint.child for joint in tree.children(link)]
    out: dict[str, int] = {}
    for link in reversed(order):
        out[link] = max(
            (out[joint.child] + joint.moves for joint in tree.children(link)), default=0
        )
    return out


def _is_aside(joint: UrdfJoint, beyond: int) -> bool:
    """Return whether a joint belongs to a gripper, a balancer, a sensor or a body and not to an
    arm; `beyond` how many more move behind it.
    """
    own, link = words_of(joint.name), words_of(joint.child)
    both = f"{own} {link}"
    words = [own, link]
    if not WRIST.search(own) and (
        any(FINGERS.search(each) for each in words) or (GRIPPER.search(own) and beyond < ARM)
    ):
        return True
    if any(BODY.search(each) for each in words):
        return True
    return (
        beyond < ARM
        and not WRIST.search(both)
        and any(BALANCER.search(each) or ASIDE.search(each) for each in words)
    )


def _best(tree: UrdfTree, spots: list[_LinkPlace]) -> Choice | None:
    """Choose among these spots; the ends of arms as good are the choice's rivals."""
    if not spots:
        return None
    by_link = {spot.link: spot for spot in spots}
    least = min(ARM, max(len(spot.way) for spot in spots))
    named = [spot for spot in spots if len(spot.way) >= least and rank_of(spot.link) < len(RANKS)]
    arms: dict[str, _LinkPlace] = {}
    for end in _ends(spots):
        on_way = [spot for spot in named if spot.way == end[: len(spot.way)]]
        chosen = min(on_way, key=_merit) if on_way else _by_structure(tree, spots, end)
        arms.setdefault(chosen.end, chosen)
    kept = _without_hands(tree, spots, list(arms.values()), named)
    first = min(kept, key=lambda spot: (spot not in named, *_merit(spot)))
    rivals = [spot for spot in kept if spot is not first and _is_rival(spot, first, named)]
    rivals += [
        spot
        for spot in named
        if spot.end == first.end
        and _merit(spot)[:3] == _merit(first)[:3]
        and mirrored(spot.link, first.link)
    ]
    others = sorted(
        (spot for spot in named if spot is not first and first.way[: len(spot.way)] == spot.way),
        key=_merit,
    )
    others += [
        spot
        for spot in kept
        if len(spot.way) >= ARM and spot is not first and spot not in others and spot not in rivals
    ]

    def choice(spot: _LinkPlace) -> Choice:
        return Choice(spot.link, len(set(by_link[spot.link].way)), spot in named)

    return replace(
        choice(first), others=tuple(spot.link for spot in others), rivals=tuple(map(choice, rivals))
    )


def _merit(spot: _LinkPlace) -> tuple[int, int, int, bool]:
    """Order spots, best first: more moving joints, a better name, fewer fixed joints behind the
    last moving one, a name that ends in the word.
    """
    rank = rank_of(spot.link)
    words = re.sub("_(?:link|frame)$", "", words_of(spot.link))
    last = rank < len(RANKS) and any(
        match.end() == len(words) for match in RANKS[rank].finditer(words)
    )
    return -len(spot.way), rank, spot.fixed, not last


def _ends(spots: list[_LinkPlace]) -> list[tuple[str, ...]]:
    """Return the ways that no other way goes on from, longest first, else in the file's order."""
    ways = sorted(dict.fromkeys(spot.way for spot in spots), key=len, reverse=True)
    on_the_way = {way[:-1] for way in ways}
    return [way for way in ways if way not in on_the_way]


def _by_structure(tree: UrdfTree, spots: list[_LinkPlace], way: tuple[str, ...]) -> _LinkPlace:
    """Return the link behind the last joint of a way, or the nearest pure frame that is fixed to
    it.
    """
    there = sorted((spot for spot in spots if spot.way == way), key=lambda spot: spot.fixed)
    frames = (
        spot
        for spot in there
        if spot.fixed and tree.links[spot.link].is_frame and not ASIDE.search(words_of(spot.link))
    )
    return next(frames, there[0])


def _without_hands(
    tree: UrdfTree, spots: list[_LinkPlace], arms: list[_LinkPlace], named: list[_LinkPlace]
) -> list[_LinkPlace]:
    """Put the link that carries them in the place of several short ends on one arm: fingers without
    a finger's name.
    """
    nameless = [spot for spot in arms if spot not in named]
    beyond: dict[tuple[str, ...], set[str]] = defaultdict(set)
    for spot in nameless:
        for k in range(max(ARM + 1, len(spot.way) - _LONGEST_TAIL), len(spot.way)):
            beyond[spot.way[:k]].add(spot.way[k])
    out: dict[str, _LinkPlace] = {}
    for spot in arms:
        hands = (
            [
                way
                for way in (spot.way[:k] for k in range(len(spot.way)))
                if len(beyond.get(way, ())) > 1
            ]
            if spot in nameless
            else []
        )
        carrier = _by_structure(tree, spots, hands[0]) if hands else spot
        out.setdefault(carrier.end, carrier)
    return list(out.values())


def _is_rival(spot: _LinkPlace, first: _LinkPlace, named: list[_LinkPlace]) -> bool:
    """Return whether the end of an arm is as good as the first of as many joints, or its mirror
    image by name.
    """
    common = _common(spot.way, first.way)
    own = len(spot.way) - common
    if common in (len(first.way), len(spot.way)):
        return False
    if mirrored(spot.link, first.link) or mirrored(spot.end, first.end):
        return True
    same_length = len(spot.way) == len(first.way)
    return same_length and (spot in named or first not in named or own >= ARM)


def _common(one: tuple[str, ...], other: tuple[str, ...]) -> int:
    return next(
        (k for k, (a, b) in enumerate(zip(one, other, strict=False)) if a != b),
        min(len(one), len(other)),
    )


def listed_ends(choices: Iterable[Choice]) -> list[str]:
    """Write the ends of arms with their side, where their names have one, and the number of their
    joints.
    """
    return [
        f"{side_of(each.link)}{each.link} ({each.joints} joint{'s' * (each.joints != 1)})"
        for each in choices
    ]
