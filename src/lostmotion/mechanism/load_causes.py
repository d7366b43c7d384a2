"""Loads by cause: the same arm with one cause of load at a time, and the bending of each link by cause."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.carry import carry
from lostmotion.mechanism.serial import Conditions, frames

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.spatial import Floats

# In the order of the tables.
CAUSES: Final = ("payload", "process force", "tool", "links", "joints and drives")
OWN_WEIGHT: Final = "own weight"
# Names for a link: only masses outboard of its tip load it.
NEXT: Final = {"links": "next links", "joints and drives": "next joints and drives"}
_BLOCK: Final = 1024
_NONE: Final = (0.0, 0.0, 0.0)


def single_cause_arms(arm: Arm) -> dict[str, Arm]:
    """Return the arm with one cause of load at a time, by its name in `CAUSES`; causes that the arm does not have are omitted.

    Wrenches are linear in the masses and in the process force, so the wrenches of these arms add up to those of the whole arm.
    """
    joints = arm.joints
    weightless = tuple(joint.model_copy(update={"mass": 0.0, "link": joint.link.model_copy(update={"mass": 0.0})}) for joint in joints)
    links = tuple(joint.model_copy(update={"mass": 0.0}) for joint in joints)
    units = tuple(joint.model_copy(update={"link": joint.link.model_copy(update={"mass": 0.0})}) for joint in joints)
    hangs = arm.payload.model_copy(update={"force": _NONE, "moment": _NONE})
    pulls = arm.payload.model_copy(update={"mass": 0.0})
    nothing = hangs.model_copy(update={"mass": 0.0})
    no_tool = arm.tool.model_copy(update={"mass": 0.0})
    made = {
        "payload": (weightless, no_tool, hangs, arm.payload.mass),
        "process force": (weightless, no_tool, pulls, any(arm.payload.force) or any(arm.payload.moment)),
        "tool": (weightless, arm.tool, nothing, arm.tool.mass),
        "links": (links, no_tool, nothing, any(joint.link.total_mass for joint in joints)),
        "joints and drives": (units, no_tool, nothing, any(joint.total_mass for joint in joints)),
    }
    return {
        name: arm.model_copy(update={"joints": chain, "tool": tool, "payload": payload})
        for name, (chain, tool, payload, there) in made.items()
        if there
    }


@dataclass(frozen=True)
class LinkBending:
    """The bending of one link under its load.

    deflection, slope  largest of the tip against the joint, across the link (m, rad), at the poses deflection_index and slope_index
    by_cause           (deflection, slope, share) of each cause: its components along the whole deflection and slope at those poses, which add up to
                       them; and its share of the tool's mean-square error over all poses, which adds up to the share of the link's bending
    """

    joint: str
    length: float
    deflection: float
    deflection_index: int
    slope: float
    slope_index: int
    by_cause: dict[str, tuple[float, float, float]]


def bending(arm: Arm, q: Floats, bias: Floats, mean_square: float) -> list[LinkBending]:
    """Return the bending of each elastic link over these poses, by payload, own weight, next links, next joints and drives.

    q            (pose, joint) rad or m
    bias         (pose, 3) m, the tool's error that follows from load and pose
    mean_square  m^2, of the tool's whole error, for the shares

    Exact by superposition: links are linear in their load.
    """
    whole: dict[str, Floats] = {}
    shared: dict[str, dict[str, float]] = {}
    for start in range(0, len(q), _BLOCK):
        here = slice(start, start + _BLOCK)
        for joint, bent in _link_deflections(arm, q[here]).items():
            sizes = whole.setdefault(joint, np.zeros((len(q), 2)))
            sizes[here] = np.linalg.norm(sum(bent.across.values()).reshape(-1, 2, 3), axis=2)  # type: ignore[union-attr]
            sums = shared.setdefault(joint, dict.fromkeys(bent.at_tool, 0.0))
            for cause, shift in bent.at_tool.items():
                sums[cause] += float(np.vdot(shift, bias[here]))
    return [_link_bending(arm, q, joint, sizes, shared[joint], mean_square * len(q)) for joint, sizes in whole.items() if sizes.any()]


def _link_bending(arm: Arm, q: Floats, joint: str, sizes: Floats, shared: dict[str, float], squares: float) -> LinkBending:
    slopest, furthest = (int(each) for each in sizes.argmax(axis=0))
    slopes = _along_whole({cause: twist[0, :3] for cause, twist in _link_deflections(arm, q[[slopest]])[joint].across.items()})
    shifts = _along_whole({cause: twist[0, 3:] for cause, twist in _link_deflections(arm, q[[furthest]])[joint].across.items()})
    length = next(each.link.reach for each in arm.joints if each.name == joint)
    parts = {cause: (shifts[cause], slopes[cause], shared[cause] / squares if squares else 0.0) for cause in shifts}
    return LinkBending(joint, length, float(sizes[furthest, 1]), furthest, float(sizes[slopest, 0]), slopest, parts)


def _along_whole(parts: dict[str, Floats]) -> dict[str, float]:
    """Return the component of each contribution along their sum."""
    whole = np.sum(list(parts.values()), axis=0)
    size = float(np.linalg.norm(whole))
    return {cause: float(part @ whole) / size if size else 0.0 for cause, part in parts.items()}


@dataclass(frozen=True, slots=True)
class _LinkDeflection:
    """Deflection of a link by cause: twist (pose, 6) of its tip across the link, in the tip's axes, and displacement (pose, 3) of the tool."""

    across: dict[str, Floats]
    at_tool: dict[str, Floats]


def _link_deflections(arm: Arm, q: Floats) -> dict[str, _LinkDeflection]:
    at = frames(arm, q)
    felt, felt_alone = Conditions(arm, q, at), {cause: Conditions(one, q, at) for cause, one in single_cause_arms(arm).items()}
    links: dict[str, list[PlacedTerm]] = {}
    for of in arm.terms:
        if of.kind == "link" and of.term.level == "design" and of.term.form.reads:
            links.setdefault(of.owner, []).append(of)
    out = {}
    for joint in arm.joints:
        terms = links.get(f"joints.{joint.name}.link")
        if terms:
            place, whole = terms[0].place, felt(terms[0])
            acting = {OWN_WEIGHT: replace(whole, wrench=np.zeros_like(whole.wrench))}
            acting |= {cause: replace(one(terms[0]), gravity=np.zeros_like(whole.gravity)) for cause, one in felt_alone.items()}
            parts = {cause: np.sum([of.term.scale * of.term.form.screw(one) for of in terms], axis=0).T for cause, one in acting.items()}
            carried, off = carry(arm.tree, at, place)[:, 3:], _off_the_line(at, arm.tree.places[place].parent, place)
            out[joint.name] = _LinkDeflection(
                {cause: np.einsum("pij,pj->pi", off, twist.reshape(-1, 3)).reshape(-1, 6) for cause, twist in parts.items()},
                {cause: np.einsum("pij,pj->pi", carried, twist) for cause, twist in parts.items()},
            )
    return out


def _off_the_line(at: Floats, joint: int, tip: int) -> Floats:
    """Return the matrices (2 per pose, 3, 3) that remove from a vector in the tip's axes its component along the line from joint to tip."""
    line = np.einsum("pij,pi->pj", at[tip, :, :3, :3], at[tip, :, :3, 3] - at[joint, :, :3, 3])
    line /= np.maximum(np.linalg.norm(line, axis=1), np.finfo(float).tiny)[:, None]
    return np.repeat(np.eye(3) - line[:, :, None] * line[:, None, :], 2, axis=0)
