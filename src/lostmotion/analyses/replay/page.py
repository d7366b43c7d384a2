"""One of the largest errors of a run, term by term, and its sheet."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from lostmotion.analyses.result import Result
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.printed import digits
from lostmotion.reporting.provenance import (
    as_known,
    assumed_drives_sentences,
    at_least,
    missing_sentences,
    provenance_facts,
)
from lostmotion.reporting.sheet import Cell, Sheet, length, several, table
from lostmotion.runs.design_names import design_name
from lostmotion.runs.replay import Replay

if TYPE_CHECKING:
    from lostmotion.reporting.sheet import Section

_MOST_TERMS: Final = 400
# Terms below this share of the error are added up in one line.
_LEAST_TERM: Final = 1e-3
# Terms that the headline names.
_NAMED: Final = 3
_NOT_REPRODUCED: Final = (
    "The stored figure is not reproduced: the store is damaged or was made by other code."
)


@dataclass(frozen=True, repr=False)
class Replayed(Replay, Result):
    """One of the largest errors of a run: `found` has its pose, draws and terms."""

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed and written."""
        return _sheet(self)

    @property
    def failure(self) -> str:
        """Return that the error is not reproduced, where it is not."""
        if self.reproduced:
            return ""
        return (
            "an error is not reproduced: the store holds other figures than its job makes\n  run "
            "the same `lostmotion sweep` in another folder"
        )

    def __repr__(self) -> str:
        """Return what was replayed, in a line."""
        at = self.found
        return (
            f"<Replay of design {at.design}, pose {at.pose}, robot {at.robot}, visit {at.visit}: "
            f"{at.error:.6g} m>"
        )


def _sheet(replay: Replay) -> Sheet:
    at, order = replay.found, replay.store.order
    where = f"robot {at.robot}, visit {at.visit}, pose {at.pose}" + (
        f", {design_name(order.axes, at.design)}" if order.axes else ""
    )
    same = (
        "identical"
        if replay.kernel == at.error
        else f"differs by {abs(replay.kernel - at.error):.1e} m"
    )
    notes: tuple[str, ...] = (
        (
            (
                "the store was made with other versions, the last bits may differ: "
                f"{', '.join(replay.others)}"
            ),
        )
        if replay.others
        else ()
    )
    if replay.fallen:
        names = ", ".join(str(each) for each in replay.fallen)
        notes += (f"designs that fall at some poses have no figures, and are excluded: {names}",)
    pose = [
        (joint, Cell(value, "°" if kind == "revolute" else "mm", stated=True))
        for (joint, kind), value in zip(replay.joints, at.q, strict=True)
    ]
    tool = [
        (axis, length(float(replay.tool[k, 3]), stated=True), replay.error[k])
        for k, axis in enumerate("XYZ")
    ]
    composed = float(math.dist(replay.exact[:3, 3], replay.tool[:3, 3]))
    lengths = (
        ("stored", at.error, "from the run"),
        ("block recomputed", replay.kernel, same),
        ("sum over terms", replay.length, f"relative difference {replay.apart:.1e}"),
        (
            "exact composition",
            composed,
            "with finite rotations; the study is of first order",
        ),
    )
    columns = {"nominal": "m", "error": "m"}
    return Sheet(
        name=replay.arm,
        subject="one of the largest errors, replayed",
        verdict=_verdict(replay, where) if replay.reproduced else f"{_NOT_REPRODUCED} {where}.",
        sections=(
            table("length", "Magnitude of the error", ("value",), lengths, unit="m"),
            table("pose", "Joint values", ("value",), pose),
            table("tool", "Tool position, base frame", columns, tool, _attitude(replay)),
            *_terms(replay),
        ),
        counts=where,
        notes=notes,
        source=f"seed {order.seed}.",
        seed=order.seed,
        facts={
            **at.facts(),
            "design": at.design,
            "stated": order.stated(at.design),
            "replayed_m": replay.length,
            "same_bits": replay.kernel == at.error,
            "reproduced": replay.reproduced,
            **provenance_facts(replay.known),
        },
    )


def _verdict(replay: Replay, where: str) -> str:
    error = at_least(length(replay.found.error), replay.known)
    return " ".join(
        [
            f"An error of {error}: {where}.{_largest(replay)}",
            *assumed_drives_sentences(replay.known),
            *missing_sentences(replay.known),
        ]
    )


def _largest(replay: Replay) -> str:
    """Return the sentence, after a space, that names the terms with the largest component along the
    error, which are the first ones.
    """
    named = [
        f"{short_name(term.name)} {as_known(length(term.along), replay.known)}"
        for term in replay.terms[:_NAMED]
        if abs(term.along) >= _LEAST_TERM * replay.length
    ]
    if not named:
        return ""
    return (
        f" Largest along it, of {several(len(replay.terms), 'term')}: {', '.join(named)}; all with "
        "--full."
    )


def _attitude(replay: Replay) -> str:
    turn = replay.tool[:3, :3]
    yaw, pitch, roll = (
        math.atan2(turn[1, 0], turn[0, 0]),
        math.atan2(-turn[2, 0], math.hypot(turn[2, 1], turn[2, 2])),
        math.atan2(turn[2, 1], turn[2, 2]),
    )
    return (
        f"orientation: roll {math.degrees(roll):.2f}°, pitch {math.degrees(pitch):.2f}°, yaw "
        f"{math.degrees(yaw):.2f}°"
    )


def _terms(replay: Replay) -> list[Section]:
    """Return the largest terms by level: draw and contribution to the magnitude; then the
    displacement of the tool by each.
    """
    shown = [
        term
        for term in replay.terms[:_MOST_TERMS]
        if abs(term.along) >= _LEAST_TERM * replay.length
    ]
    out, moves = [], []
    for key, (title, levels) in _LEVELS.items():
        rows = []
        for term in (term for term in shown if term.level in levels):
            name = short_name(term.name)
            rows.append((name, term.draw, term.along, _share(term.along, replay)))
            moves.append((name, *term.shift))
        if rows:
            whole = sum(term.along for term in replay.terms if term.level in levels)
            note = (
                f"together {digits(whole * 1e6)} µm, {Cell(_share(whole, replay), '%')} of the "
                "magnitude"
            )
            columns = {"draw": "1", "along": "µm", "share": "%"}
            out.append(table(f"terms_{key}", title, columns, rows, note))
    note = (
        "along, above: component along the total error, so that all terms add up to its "
        "magnitude; draws have mean 0 and variance 1"
    )
    rest = replay.terms[len(shown) :]
    if rest:
        together = digits(sum(term.along for term in rest) * 1e6)
        note += (
            f". {several(len(rest), 'more term')}, each below {100 * _LEAST_TERM:g} % of the "
            f"magnitude, add {together} µm"
        )
    title = "Tool displacement by each term, base frame"
    return [*out, table("moves", title, ("X", "Y", "Z"), moves, note, unit="µm")]


def _share(along: float, replay: Replay) -> float:
    return along / replay.length if replay.length else 0.0


# Section -> its title and the levels of chance of its terms.
_LEVELS: Final = {
    "design": ("Terms determined by load and pose", ("design",)),
    "robot": ("Terms of this robot", ("robot",)),
    "visit": ("Terms of this visit", ("visit", "robot x visit")),
}
