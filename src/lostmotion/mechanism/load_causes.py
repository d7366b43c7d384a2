"""Loads by cause: the arm under one cause of load at a time, and the bending of each link by
cause.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.standing import standing, standing_at
from lostmotion.mechanism.state import State, blocks_of, state_of

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.spatial import Floats

# Causes of load, in the order of the tables.
CAUSES: Final = ("payload", "process force", "tool", "links", "joints and drives")
OWN_WEIGHT: Final = "own weight"
# Names of causes in the bending of a link: only masses outboard of its tip load it.
OUTBOARD_CAUSES: Final = {"links": "next links", "joints and drives": "next joints and drives"}
_NONE: Final = (0.0, 0.0, 0.0)


def single_cause_arms(arm: Arm) -> dict[str, Arm]:
    """Return the arm under one cause of load at a time; keys are the names in `CAUSES`, without
    causes that the arm does not have.

    Wrenches are linear in the masses and in the process force, so the wrenches of these arms add up
    to those of the whole arm.
    """
    joints = arm.joints
    massless = tuple(
        joint.model_copy(update={"mass": 0.0, "link": joint.link.model_copy(update={"mass": 0.0})})
        for joint in joints
    )
    links_only = tuple(joint.model_copy(update={"mass": 0.0}) for joint in joints)
    units_only = tuple(
        joint.model_copy(update={"link": joint.link.model_copy(update={"mass": 0.0})})
        for joint in joints
    )
    weight_only = arm.payload.model_copy(update={"force": _NONE, "moment": _NONE})
    process_only = arm.payload.model_copy(update={"mass": 0.0})
    no_payload = weight_only.model_copy(update={"mass": 0.0})
    no_tool = arm.tool.model_copy(update={"mass": 0.0})
    variants = {
        "payload": (massless, no_tool, weight_only, arm.payload.mass),
        "process force": (
            massless,
            no_tool,
            process_only,
            any(arm.payload.force) or any(arm.payload.moment),
        ),
        "tool": (massless, arm.tool, no_payload, arm.tool.mass),
        "links": (links_only, no_tool, no_payload, any(joint.link.total_mass for joint in joints)),
        "joints and drives": (
            units_only,
            no_tool,
            no_payload,
            any(joint.total_mass for joint in joints),
        ),
    }
    return {
        name: arm.model_copy(update={"joints": chain, "tool": tool, "payload": payload})
        for name, (chain, tool, payload, is_present) in variants.items()
        if is_present
    }


@dataclass(frozen=True)
class LinkBending:
    """The bending of one link under its load.

    joint              name of the joint that carries the link
    length             distance from the joint to the link's tip, m
    deflection, slope  largest of the tip relative to the joint, across the link (m, rad); the poses
                       are deflection_index and slope_index
    by_cause           (deflection, slope, share) of each cause. The first two are components along
                       the total deflection and slope at those poses, and add up to them. The third
                       is the share of the tool's mean-square error over all poses; these add up to
                       the share of the bending of this link.
    """

    joint: str
    length: float
    deflection: float
    deflection_index: int
    slope: float
    slope_index: int
    by_cause: dict[str, tuple[float, float, float]]


def bending(arm: Arm, q: Floats, bias: Floats, mean_square: float) -> list[LinkBending]:
    """Return the bending of each elastic link over these poses, by cause: payload, process force,
    tool, own weight, masses outboard of the link.

    q            (pose, joint) rad or m
    bias         (pose, 3) systematic error of the tool, which follows from load and pose alone, m
    mean_square  mean square of the whole error of the tool, m^2, to which the shares refer

    By superposition at the loads where the arm stands: the deflection of a link is linear in its
    load. The tool moves by the mean of what a deflection does at the command and where the arm
    stands; what that neglects is of third order. Links without bending are omitted.
    """
    whole: dict[str, Floats] = {}
    shared: dict[str, dict[str, float]] = {}
    causes = single_cause_arms(arm)
    for here, values in blocks_of(q):
        for joint, bent in _link_deflections(standing_at(arm, values), causes).items():
            sizes = whole.setdefault(joint, np.zeros((len(q), 2)))
            sizes[here] = np.linalg.norm(sum(bent.across.values()).reshape(-1, 2, 3), axis=2)  # type: ignore[union-attr]
            sums = shared.setdefault(joint, dict.fromkeys(bent.at_tool, 0.0))
            for cause, shift in bent.at_tool.items():
                sums[cause] += float(np.vdot(shift, bias[here]))
    # Poses at which each link has its largest slope and its largest deflection.
    largest = {joint: sizes.argmax(axis=0) for joint, sizes in whole.items() if sizes.any()}
    if not largest:
        return []
    at = standing(state_of(arm, q[np.concatenate(list(largest.values()))]))
    there = _link_deflections(at, causes)
    return [
        _link_bending(
            arm,
            joint,
            whole[joint],
            {cause: twist[2 * k : 2 * k + 2] for cause, twist in there[joint].across.items()},
            {
                cause: each / (mean_square * len(q)) if mean_square else 0.0
                for cause, each in shared[joint].items()
            },
        )
        for k, joint in enumerate(largest)
    ]


def _link_bending(
    arm: Arm, joint: str, sizes: Floats, across: dict[str, Floats], shares: dict[str, float]
) -> LinkBending:
    """Return the bending of a link, with its deflections `across` by cause at the poses of its
    largest slope and of its largest deflection.
    """
    steepest, farthest = (int(each) for each in sizes.argmax(axis=0))
    slopes = _along_whole({cause: twist[0, :3] for cause, twist in across.items()})
    shifts = _along_whole({cause: twist[1, 3:] for cause, twist in across.items()})
    length = next(each.link.reach for each in arm.joints if each.name == joint)
    parts = {cause: (shifts[cause], slopes[cause], shares[cause]) for cause in shifts}
    return LinkBending(
        joint,
        length,
        float(sizes[farthest, 1]),
        farthest,
        float(sizes[steepest, 0]),
        steepest,
        parts,
    )


def _along_whole(parts: dict[str, Floats]) -> dict[str, float]:
    """Return the component of each contribution along their sum."""
    whole = np.sum(list(parts.values()), axis=0)
    size = float(np.linalg.norm(whole))
    return {cause: float(part @ whole) / size if size else 0.0 for cause, part in parts.items()}


@dataclass(frozen=True, slots=True)
class _LinkDeflection:
    """Deflection of a link by cause.

    across   twist (pose, 6) of its tip across the link, rad and m, in the tip's axes
    at_tool  displacement (pose, 3) of the tool, m
    """

    across: dict[str, Floats]
    at_tool: dict[str, Floats]


def _link_deflections(state: State, causes: dict[str, Arm]) -> dict[str, _LinkDeflection]:
    """Return the deflection of each elastic link; `causes` as `single_cause_arms` returns them."""
    command = replace(state, frames=state.commanded, equilibrium=None)
    arm, conditions = state.arm, state.conditions()
    conditions_by_cause = {
        cause: replace(state, arm=one).conditions() for cause, one in causes.items()
    }
    links: dict[str, list[PlacedTerm]] = {}
    for placed in arm.terms:
        if placed.kind == "link" and placed.term.level == "design" and placed.term.form.reads:
            links.setdefault(placed.owner, []).append(placed)
    out = {}
    for joint in arm.joints:
        terms = links.get(f"joints.{joint.name}.link")
        if terms:
            place, whole = terms[0].place, conditions(terms[0])
            acting = {OWN_WEIGHT: replace(whole, wrench=np.zeros_like(whole.wrench))}
            acting |= {
                cause: replace(one(terms[0]), gravity=np.zeros_like(whole.gravity))
                for cause, one in conditions_by_cause.items()
            }
            parts = {
                cause: np.sum(
                    [placed.term.scale * placed.term.form.screw(one) for placed in terms], axis=0
                ).T
                for cause, one in acting.items()
            }
            carried, off = (
                (command.carry(place) + state.carry(place))[:, 3:] / 2,
                _projection_across(state.frames, arm.tree.places[place].parent, place),
            )
            out[joint.name] = _LinkDeflection(
                {
                    cause: np.einsum("pij,pj->pi", off, twist.reshape(-1, 3)).reshape(-1, 6)
                    for cause, twist in parts.items()
                },
                {cause: np.einsum("pij,pj->pi", carried, twist) for cause, twist in parts.items()},
            )
    return out


def _projection_across(at: Floats, joint: int, tip: int) -> Floats:
    """Return matrices (2 per pose, 3, 3) that remove the component along the line from joint to tip
    of a vector in the tip's axes.
    """
    line = np.einsum("pij,pi->pj", at[tip, :, :3, :3], at[tip, :, :3, 3] - at[joint, :, :3, 3])
    line /= np.maximum(np.linalg.norm(line, axis=1), np.finfo(float).tiny)[:, None]
    return np.repeat(np.eye(3) - line[:, :, None] * line[:, None, :], 2, axis=0)
