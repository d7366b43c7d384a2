"""Denavit-Hartenberg rows as places; the key names the convention, because the letters alone do
not.

dh    standard: frame i in frame i-1 is Rz(theta + q) Tz(d) Tx(a) Rx(alpha)
mdh   modified (Craig): Rx(alpha) Tx(a) Rz(theta + q) Tz(d), where a and alpha belong to the link
      before

On a sliding joint q adds to d in both. Each value may have a ± tolerance of its own, independent of
the others: theta and d turn and shift the joint's axis about and along itself, at its seat; a and
alpha shift and turn the far end of the link (dh), or of the link before (mdh), along and about its
x. Sources: J. Denavit, R. Hartenberg, J. Appl. Mech. 22 (1955) 215; J. Craig, Introduction to
Robotics, ch. 3.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, TypeAlias, TypeVar

from pydantic import ValidationError

from lostmotion.errors import shown
from lostmotion.io.provenance import rename_assumed
from lostmotion.io.validation_errors import problems
from lostmotion.parts.error_source import AngleDim, LengthDim, Part
from lostmotion.parts.link import Frame
from lostmotion.spatial import turn
from lostmotion.units import Toleranced

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.io.draft import Draft
    from lostmotion.spatial import Floats

T = TypeVar("T")
# By name: tilts about and offsets along x, y and z.
Tolerances: TypeAlias = "dict[str, tuple[Toleranced, ...]]"
_EXACT: Final = Toleranced(0.0)
DH_KEYS: Final = ("dh", "mdh")
# What a row already says: where a joint sits, where its axis points, where its link leads.
_STATED_BY_JOINT: Final = ("origin", "axis")
_STATED_BY_LINK: Final = ("length", "direction", "tip")
DH_TOLERANCES: Final = (
    'dh = { a = "400 mm ± 0.1 mm", alpha = "90 deg ± 0.02 deg", d = "162.5 mm ± 0.1 mm", theta = '
    '"0 deg ± 0.02 deg" }'
)
DH_EXAMPLES: Final = {
    key: f'{key} = {{ a = "0 mm", alpha = "90 deg", d = "162.5 mm", theta = "0 deg" }}'
    for key in DH_KEYS
}


class DhRow(Part):
    """One row of a table: all four values with their tolerances, m and rad."""

    a: LengthDim
    alpha: AngleDim
    d: LengthDim
    theta: AngleDim

    @property
    def has_tolerances(self) -> bool:
        """Return whether one of the values has a ±."""
        return any(value.tolerance for value in (self.a, self.alpha, self.d, self.theta))


_STAND_IN: Final = DhRow(a=1.0, alpha=0.0, d=1.0, theta=0.0)


def standard(rows: Sequence[DhRow | None]) -> list[tuple[Frame, Frame]]:
    """Return (origin, tip) of each row of standard Denavit-Hartenberg values: the joint's seat and
    the end of its link; axes along z.
    """
    stated = (row for row in rows if row is not None)
    return [
        (
            Frame(rpy=(0.0, 0.0, row.theta.nominal)),
            Frame(xyz=(row.a.nominal, 0.0, row.d.nominal), rpy=(row.alpha.nominal, 0.0, 0.0)),
        )
        for row in stated
    ]


def modified(rows: Sequence[DhRow | None]) -> list[tuple[Frame, Frame]]:
    """Return (origin, tip) of each row of modified Denavit-Hartenberg values: the joint's seat and
    the end of its link; axes along z.

    Row i's a and alpha describe link i-1, so they go into its tip, and every link is the body
    between two joints; the first row's, and those of a row behind a joint without one (None), go
    into its own joint's origin, for want of a link before it that is a row's.
    """
    out = []
    for index, row in enumerate(rows):
        if row is None:
            continue
        after = rows[index + 1] if index + 1 < len(rows) else None
        theta, d = row.theta.nominal, row.d.nominal
        origin = Frame(rpy=(0.0, 0.0, theta))
        if _leads(rows, index):
            rotation = (turn((1, 0, 0), row.alpha.nominal) @ turn((0, 0, 1), theta))[:3, :3]
            origin = Frame(xyz=(row.a.nominal, 0.0, 0.0), rpy=rpy_of(rotation))
        tip = (
            Frame(xyz=(after.a.nominal, 0.0, d), rpy=(after.alpha.nominal, 0.0, 0.0))
            if after
            else Frame(xyz=(0.0, 0.0, d))
        )
        out.append((origin, tip))
    return out


def _leads(rows: Sequence[DhRow | None], index: int) -> bool:
    """Return whether a row of modified values has no row before it, whose link could take its a and
    alpha.
    """
    return index == 0 or rows[index - 1] is None


def _standard_tolerances(rows: Sequence[DhRow | None]) -> list[tuple[Tolerances, Tolerances]]:
    """Return the tolerances of seat and tip of each row: about and along z of the joint, then about
    and along x of the tip.
    """
    return [
        (_along("z", row.theta, row.d), _along("x", row.alpha, row.a))
        for row in rows
        if row is not None
    ]


def _modified_tolerances(rows: Sequence[DhRow | None]) -> list[tuple[Tolerances, Tolerances]]:
    """Return the tolerances of seat and tip of each row; a leading row has its own a and alpha at
    its seat, along x before the turn by theta.
    """
    out = []
    for index, row in enumerate(rows):
        if row is None:
            continue
        after = rows[index + 1] if index + 1 < len(rows) else None
        seat = _along("z", row.theta, row.d)
        if _leads(rows, index):
            across = _along("x", row.alpha, row.a)
            seat = {key: (across[key][0], *seat[key][1:]) for key in seat}
        out.append(
            (seat, _along("x", after.alpha, after.a) if after else _along("x", _EXACT, _EXACT))
        )
    return out


def _along(letter: str, angle: Toleranced, length: Toleranced) -> Tolerances:
    """Return the tolerances of a frame about and along one of its axes."""
    at = "xyz".index(letter)
    return {
        name: tuple(replace(value, nominal=0.0) if k == at else _EXACT for k in range(3))
        for name, value in (("tilt", angle), ("offset", length))
    }


def rpy_of(rotation: Floats) -> tuple[float, float, float]:
    """Return roll, pitch and yaw (rad) of a rotation (3, 3). Exact to rounding everywhere; at a
    pitch of 90 degrees one of many answers.
    """
    yaw = math.atan2(rotation[1, 0], rotation[0, 0])
    # Without the yaw, pitch and roll stand in entries of full size, also where the yaw itself was
    # free.
    rest = turn((0, 0, 1), -yaw)[:3, :3] @ rotation
    return math.atan2(-rest[1, 2], rest[1, 1]), math.atan2(-rest[2, 0], rest[0, 0]), yaw


_CONVENTIONS: Final = {
    "dh": (standard, _standard_tolerances),
    "mdh": (modified, _modified_tolerances),
}


def place_by_rows(draft: Draft) -> None:
    """Replace the rows of a draft's joints by origins and tips; note rows that are wrong, mixed, or
    say what other keys say too.

    A fixed joint may stand beside them without a row, with origin and link of its own: a flange, a
    plate, a sensor.
    """
    keys = [key for key in DH_KEYS if any(key in joint for _, joint in draft.joints)]
    if not keys:
        return
    convention = keys[0]
    rows: list[DhRow | None] = []
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
    having = [
        (index, joint, row)
        for (index, joint), row in zip(draft.joints, rows, strict=True)
        if row is not None
    ]
    place, tolerate = _CONVENTIONS[convention]
    for (_, joint, _), (origin, tip) in zip(
        having, _by_chain(place, draft.joints, rows), strict=True
    ):
        rename_assumed(joint, {convention: "origin"})
        joint["origin"] = origin
        link = joint.setdefault("link", {})
        if isinstance(link, dict):
            link["tip"] = tip
    if any(row.has_tolerances for _, _, row in having):
        for (index, joint, row), tolerances in zip(
            having, _by_chain(tolerate, draft.joints, rows), strict=True
        ):
            _tolerate(draft, index, joint, row, tolerances, convention)


def _by_chain(
    convention: Callable[[Sequence[DhRow | None]], list[T]],
    joints: Sequence[tuple[int, dict[str, Any]]],
    rows: Sequence[DhRow | None],
) -> list[T]:
    """Return what a convention makes of each row, each chain by itself: a joint with `after` begins
    another one.
    """
    starts = [0, *(k for k, (_, joint) in enumerate(joints) if k and "after" in joint), len(rows)]
    return [
        placed
        for first, last in itertools.pairwise(starts)
        for placed in convention(rows[first:last])
    ]


def _tolerate(
    draft: Draft,
    index: int,
    joint: dict[str, Any],
    row: DhRow,
    tolerances: tuple[Tolerances, Tolerances],
    convention: str,
) -> None:
    """Put the tolerances of a table into a joint and its link; note what states them a second
    time.
    """
    seat, tip = tolerances
    given: list[tuple[dict[str, Any], tuple[str, ...], str, tuple[str, ...], dict[str, Any]]]
    axes = {"axes": ("0 rad", "0 rad", f"{-row.theta.nominal!r} rad")} if row.theta.nominal else {}
    given = [(joint, (), "mounting", ("mounting",), {**seat, **axes})]
    if isinstance(joint["link"], dict):
        given.append(
            (
                joint["link"],
                ("link",),
                "tip_tolerance",
                ("tip_tolerance", "length_tolerance"),
                dict(tip),
            )
        )
    is_assumed = "origin" in joint.get("assumed", ())
    for (holder, steps, key, others, values), tolerances_of in zip(given, tolerances, strict=False):
        if not any(value.tolerance for each in tolerances_of.values() for value in each):
            continue
        for other in others:
            if other in holder:
                expected = f"± in the values of {convention}, or {other}, not both"
                draft.refuse(
                    ("joints", index, *steps, other),
                    shown(holder.pop(other)),
                    expected,
                    DH_TOLERANCES,
                )
        holder[key] = values
        if is_assumed:
            holder["assumed"] = [*holder.get("assumed", ()), key]


def _row(draft: Draft, index: int, stated: dict[str, Any]) -> DhRow:
    row = _STAND_IN
    for key, values in stated.items():
        path = ("joints", index, key)
        try:
            row = DhRow.model_validate(values, context={"text": True})
        except ValidationError as error:
            draft.mistakes += problems(
                error,
                DhRow,
                draft.file,
                lambda inner, path=path: draft.key((*path, *inner)),  # type: ignore[misc]
            )
    return row


def _refuse_duplicates(draft: Draft, index: int, joint: dict[str, Any], convention: str) -> None:
    link = joint.get("link", {})
    for holder, names, steps in ((joint, _STATED_BY_JOINT, ()), (link, _STATED_BY_LINK, ("link",))):
        for name in names:
            if isinstance(holder, dict) and name in holder:
                expected = (
                    f"{convention} or {name}, not both; beside a row a link takes length_tolerance"
                )
                draft.refuse(
                    ("joints", index, *steps, name),
                    shown(holder.pop(name)),
                    expected,
                    DH_EXAMPLES[convention],
                )
