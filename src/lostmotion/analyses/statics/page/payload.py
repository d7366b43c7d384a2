"""Tables of the largest payload: by drives, sag and accuracy, over the workspace."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.error_model.provenance import of_compliance
from lostmotion.reporting.joint_values import joint_values, tool_place
from lostmotion.reporting.provenance import share_within_bounded
from lostmotion.reporting.sheet import Card, Cell, length, several, table

if TYPE_CHECKING:
    from lostmotion.error_model.provenance import States
    from lostmotion.loads.payload import MaxPayload, PayloadLimit
    from lostmotion.mechanism.arm import Arm
    from lostmotion.reporting.sheet import Section

_NO_LIMIT: Final = "no limit"


def payload_sentences(arm: Arm, payload: MaxPayload | None, known: States) -> list[str]:
    """Return the sentences of the headline: the largest payload at every pose, what governs it, and
    what limits nothing for want of data.
    """
    if payload is None:
        return []
    governing, out = payload.governing, []
    if governing is not None and governing.everywhere > 0:
        out.append(
            f"The largest payload at every pose is {_bounded(governing, payload, known)}; "
            f"{_cause(arm, governing)} governs."
        )
    elif governing is not None:
        count = int(governing.empty.sum())
        out.append(
            f"No payload is held at every pose: without any, {_exceeded(arm, governing)} at "
            f"{count} of {several(len(governing.values), 'pose')}."
        )
    if _nothing_rated(payload):
        out.append(
            "No drive that the payload loads has a rated torque, so the drives set no limit: "
            "that is missing data, not strength."
        )
    elif payload.unrated:
        whose = "its load is" if len(payload.unrated) == 1 else "their loads are"
        out.append(
            f"No rated torque is stated for {', '.join(payload.unrated)}: {whose} not counted."
        )
    unknown = _not_known(payload, known)
    if unknown:
        out.append(
            f"No error that grows with the payload is described, so {' and '.join(unknown)} set no "
            "limit: that is missing data, not strength."
        )
    elif governing is None and not payload.unrated:
        out.append("None of these criteria limits the payload.")
    return out


def payload_cards(arm: Arm, payload: MaxPayload | None, known: States) -> list[Card]:
    """Return a card with the largest payload at every pose, and what governs it."""
    if payload is None:
        return []
    governing = payload.governing
    if governing is None:
        return [
            Card(
                "largest payload, every pose",
                "not known" if payload.unrated or _not_known(payload, known) else _NO_LIMIT,
                _counted_by(payload),
            )
        ]
    return [
        Card(
            "largest payload, every pose",
            _bounded(governing, payload, known),
            f"{_cause(arm, governing)} governs, pose {governing.worst}",
        )
    ]


def payload_section(arm: Arm, payload: MaxPayload | None, known: States) -> tuple[Section, ...]:
    """Return the table of the largest payload by each criterion: at every pose, at the median and
    at the best pose.
    """
    if payload is None:
        return ()
    rows = [_row(arm, payload, each, known) for each in payload.limits]
    base = (
        "as the base stands"
        if payload.tilt is None
        else f"base tilted by up to {math.degrees(payload.tilt):.3g}°"
    )
    note = (
        f"static, without acceleration; payload with its stated centre of mass; {base} for the "
        "drives. Every pose: the smallest of the sampled "
        "poses, between which an arm may hold a little less. Each criterion by itself. Sag: "
        "by the weights of arm and payload, first order, without "
        "play. Accuracy: error that 95 % of the positions at a pose stay within"
    )
    if payload.unrated:
        note += f". Not rated, so not counted: {', '.join(payload.unrated)}"
    return (
        table("payload", "Largest payload", ("every pose", "median pose", "best pose"), rows, note),
    )


def payload_facts(arm: Arm, payload: MaxPayload | None) -> dict[str, Any]:
    """Return what result.json holds of the largest payload: kg by criterion, what governs, and
    where; null without a limit.
    """
    if payload is None:
        return {}
    governing = payload.governing
    return {
        "max_payload": {
            "governing": governing and governing.criterion,
            "every_pose_kg": governing and governing.everywhere,
            "not_rated": list(payload.unrated),
            "criteria": {
                each.criterion: {
                    "every_pose_kg": _plain(each.everywhere),
                    "median_kg": _plain(float(np.median(each.values))),
                    "best_kg": _plain(float(each.values.max())),
                    "limit_m": each.limit,
                    "joint": arm.driven[int(each.joints[each.worst])].name
                    if len(each.joints) and math.isfinite(each.everywhere)
                    else None,
                    "q": each.q[each.worst].tolist(),
                    "tool_m": each.tool[each.worst].tolist(),
                    "poses": len(each.values),
                }
                for each in payload.limits
            },
        }
    }


def _row(arm: Arm, payload: MaxPayload, each: PayloadLimit, known: States) -> tuple[Any, ...]:
    counted = several(len(each.values), "pose")
    unlimited = (
        "not rated"
        if each.criterion == "drives" and _nothing_rated(payload)
        else "not known"
        if each.criterion in _not_known(payload, known)
        else _NO_LIMIT
    )
    bound = bool(payload.unrated if each.criterion == "drives" else known.lower_bound)
    figures = (
        unlimited
        if math.isinf(value)
        else Cell(value, "kg", samples=counted, bound="upper" if bound else "")
        for value in (each.everywhere, float(np.median(each.values)), float(each.values.max()))
    )
    name = (
        "drives, rated torque"
        if each.limit is None
        else f"{each.criterion} within {length(each.limit, stated=True)}"
    )
    if math.isinf(each.everywhere):
        return (name, *figures)
    cause = f"{arm.driven[int(each.joints[each.worst])].name} governs; " if len(each.joints) else ""
    empty = int(each.empty.sum())
    note = (
        f"{cause}pose {each.worst}: {joint_values(arm, each.q[each.worst])}, "
        f"{tool_place(each.tool[each.worst])}"
    )
    if empty:
        note += f"; not met without payload at {empty} of {counted}"
    return (name, *figures, note)


def _cause(arm: Arm, each: PayloadLimit) -> str:
    if each.criterion == "drives":
        return f"the drive of {arm.driven[int(each.joints[each.worst])].name}"
    return f"the {each.criterion} limit of {length(each.limit or 0.0, stated=True)}"


def _exceeded(arm: Arm, each: PayloadLimit) -> str:
    if each.criterion == "drives":
        return f"{_cause(arm, each)} is overloaded"
    return f"{_cause(arm, each)} is exceeded"


def _bounded(each: PayloadLimit, payload: MaxPayload, known: States) -> str:
    """Return the payload at every pose as text, as an upper bound where joints are ideal or drives
    not rated.
    """
    text = str(Cell(each.everywhere, "kg"))
    return (
        f"at most {text}"
        if payload.unrated or _not_known(payload, known)
        else share_within_bounded(text, known)
        if each.criterion != "drives"
        else text
    )


def _not_known(payload: MaxPayload, known: States) -> list[str]:
    """Return the criteria that limit nothing because the errors that they limit are not
    described.
    """
    return [
        each.criterion
        for each in payload.limits
        if each.criterion != "drives"
        and math.isinf(each.everywhere)
        and of_compliance(known).lower_bound
    ]


def _nothing_rated(payload: MaxPayload) -> bool:
    """Return whether the drives limit no payload because none that it loads has a rated torque."""
    return bool(payload.unrated) and all(
        math.isinf(each.everywhere) for each in payload.limits if each.criterion == "drives"
    )


def _counted_by(payload: MaxPayload) -> str:
    return (
        "no drive that it loads has a rated torque"
        if _nothing_rated(payload)
        else f"by {', '.join(each.criterion for each in payload.limits)}"
    )


def _plain(value: float) -> float | None:
    return value if math.isfinite(value) else None
