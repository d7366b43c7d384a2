"""Denavit-Hartenberg rows as places; the key names the convention, because the letters alone do not.

dh    standard: frame i in frame i-1 is Rz(theta + q) Tz(d) Tx(a) Rx(alpha)
mdh   modified (Craig): Rx(alpha) Tx(a) Rz(theta + q) Tz(d), where a and alpha belong to the link before

On a sliding joint q adds to d in both. Sources: J. Denavit, R. Hartenberg, J. Appl. Mech. 22 (1955) 215; J. Craig, Introduction to Robotics, ch. 3.
"""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Any, Final

from pydantic import ValidationError

from lostmotion.errors import shown
from lostmotion.io.provenance import rename_assumed
from lostmotion.io.validation_errors import problems
from lostmotion.parts.error_source import Angle, Length, Part
from lostmotion.parts.link import Frame
from lostmotion.spatial import turn

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.io.draft import Draft
    from lostmotion.spatial import Floats

DH_KEYS: Final = ("dh", "mdh")
# What a row already says: where a joint sits, where its axis points, where its link leads.
_STATED_BY_JOINT: Final = ("origin", "axis")
_STATED_BY_LINK: Final = ("length", "direction", "tip")
DH_EXAMPLES: Final = {key: f'{key} = {{ a = "0 mm", alpha = "90 deg", d = "162.5 mm", theta = "0 deg" }}' for key in DH_KEYS}


class Row(Part):
    """One row of a table: all four values, m and rad."""

    a: Length
    alpha: Angle
    d: Length
    theta: Angle


_STAND_IN: Final = Row(a=1.0, alpha=0.0, d=1.0, theta=0.0)


def standard(rows: Sequence[Row | None]) -> list[tuple[Frame, Frame]]:
    """Return (origin, tip) of each row of standard Denavit-Hartenberg values: the joint's seat and the end of its link; axes along z."""
    stated = (row for row in rows if row is not None)
    return [(Frame(rpy=(0.0, 0.0, row.theta)), Frame(xyz=(row.a, 0.0, row.d), rpy=(row.alpha, 0.0, 0.0))) for row in stated]


def modified(rows: Sequence[Row | None]) -> list[tuple[Frame, Frame]]:
    """Return (origin, tip) of each row of modified Denavit-Hartenberg values: the joint's seat and the end of its link; axes along z.

    Row i's a and alpha describe link i-1, so they go into its tip, and every link is the body between two joints; the first row's, and those of
    a row behind a joint without one (None), go into its own joint's origin, for want of a link before it that is a row's.
    """
    out = []
    for index, row in enumerate(rows):
        if row is None:
            continue
        after = rows[index + 1] if index + 1 < len(rows) else None
        origin = Frame(rpy=(0.0, 0.0, row.theta))
        if index == 0 or rows[index - 1] is None:
            origin = Frame(xyz=(row.a, 0.0, 0.0), rpy=rpy_of((turn((1, 0, 0), row.alpha) @ turn((0, 0, 1), row.theta))[:3, :3]))
        tip = Frame(xyz=(after.a, 0.0, row.d), rpy=(after.alpha, 0.0, 0.0)) if after else Frame(xyz=(0.0, 0.0, row.d))
        out.append((origin, tip))
    return out


def rpy_of(rotation: Floats) -> tuple[float, float, float]:
    """Return roll, pitch and yaw (rad) of a rotation (3, 3). Exact to rounding everywhere; at a pitch of 90 degrees one of many answers."""
    yaw = math.atan2(rotation[1, 0], rotation[0, 0])
    # Without the yaw, pitch and roll stand in entries of full size, also where the yaw itself was free.
    rest = turn((0, 0, 1), -yaw)[:3, :3] @ rotation
    return math.atan2(-rest[1, 2], rest[1, 1]), math.atan2(-rest[2, 0], rest[0, 0]), yaw


_CONVENTIONS: Final = {"dh": standard, "mdh": modified}


def place_by_rows(draft: Draft) -> None:
    """Replace the rows of a draft's joints by origins and tips; note rows that are wrong, mixed, or say what other keys say too.

    A fixed joint may stand beside them without a row, with origin and link of its own: a flange, a plate, a sensor.
    """
    keys = [key for key in DH_KEYS if any(key in joint for _, joint in draft.joints)]
    if not keys:
        return
    convention = keys[0]
    rows: list[Row | None] = []
    for index, joint in draft.joints:
        stated = [key for key in DH_KEYS if key in joint]
        if not stated and joint.get("type") == "fixed":
            rows.append(None)
            continue
        if stated != [convention]:
            found = " and ".join(stated) or "no row"
            draft.refuse(
                ("joints", index),
                f"{found}, where another joint has {convention}",
                "the same one key for all joints of an arm that move",
                DH_EXAMPLES[convention],
            )
        rows.append(_row(draft, index, {key: joint.pop(key) for key in stated}))
        _refuse_duplicates(draft, index, joint, convention)
    having = [joint for (_, joint), row in zip(draft.joints, rows, strict=True) if row is not None]
    for joint, (origin, tip) in zip(having, _placed(_CONVENTIONS[convention], draft.joints, rows), strict=True):
        rename_assumed(joint, {convention: "origin"})
        joint["origin"] = origin
        link = joint.setdefault("link", {})
        if isinstance(link, dict):
            link["tip"] = tip


def _placed(
    convention: Callable[[Sequence[Row | None]], list[tuple[Frame, Frame]]], joints: Sequence[tuple[int, dict[str, Any]]], rows: Sequence[Row | None]
) -> list[tuple[Frame, Frame]]:
    """Return (origin, tip) per row, each chain by itself: a joint with `after` begins another one."""
    starts = [0, *(k for k, (_, joint) in enumerate(joints) if k and "after" in joint), len(rows)]
    return [placed for first, last in itertools.pairwise(starts) for placed in convention(rows[first:last])]


def _row(draft: Draft, index: int, stated: dict[str, Any]) -> Row:
    row = _STAND_IN
    for key, values in stated.items():
        path = ("joints", index, key)
        try:
            row = Row.model_validate(values, context={"text": True})
        except ValidationError as error:
            draft.mistakes += problems(error, Row, draft.file, lambda inner, path=path: draft.key((*path, *inner)))  # type: ignore[misc]
    return row


def _refuse_duplicates(draft: Draft, index: int, joint: dict[str, Any], convention: str) -> None:
    link = joint.get("link", {})
    for holder, names, steps in ((joint, _STATED_BY_JOINT, ()), (link, _STATED_BY_LINK, ("link",))):
        for name in names:
            if isinstance(holder, dict) and name in holder:
                expected = f"{convention} or {name}, not both; beside a row a link takes length_tolerance"
                draft.refuse(("joints", index, *steps, name), shown(holder.pop(name)), expected, DH_EXAMPLES[convention])
