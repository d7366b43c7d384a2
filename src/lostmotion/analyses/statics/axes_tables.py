"""Tables of the stiffness of the tool along the base's axes, and of the parts behind it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.joint_values import joint_values, tool_place
from lostmotion.reporting.sheet import Card, Cell, Row, Section

if TYPE_CHECKING:
    from lostmotion.analyses.statics.survey import Survey
    from lostmotion.error_model.provenance import States
    from lostmotion.spatial import Floats

AXES: Final = "xyz"
# Below this share of the largest compliance a direction, or a part in it, is rigid.
_RIGID: Final = 1e-6
# m/N; arms that are softer along an axis, below 0.01 N/µm, are stated in N/mm.
_SOFT: Final = 1e-4


def axes_sections(survey: Survey, counted: str) -> tuple[Section, Section]:
    """Return the stiffness along x, y and z over the poses, and that of each part alone at the
    worst pose of each axis.
    """
    values = _compliance(survey)
    rows = []
    for k, axis in enumerate(AXES):
        own = values[:, k]
        worst, best = int(own.argmax()), int(own.argmin())
        figures = tuple(
            _stiffness(survey, float(each), counted)
            for each in (own[worst], np.median(own), own[best])
        )
        note = (
            f"worst at {_at(survey, worst)}; best at pose {best}"
            if np.ptp(own) > _RIGID * own.max()
            else ""
        )
        rows.append(Row(f"along {axis}", figures, note))
    note = (
        "force on the tool point along an axis of the base over its displacement along the "
        "same axis, tool free to rotate; linearised at the arm's "
        "own load, clearances closed"
    )
    at = [f"pose {index}" for index in survey.axis_worst]
    parts = tuple(
        Row(
            short_name(name),
            tuple(
                _stiffness(survey, float(each), here) for each, here in zip(own, at, strict=True)
            ),
        )
        for name, own in zip(
            survey.parts, _without_rounding(survey, survey.axis_parts).T, strict=True
        )
    )
    alone = (
        "each at the worst pose of its axis; in series they give the stiffness there: "
        "compliances, the inverses, add. rigid: below a millionth of it"
    )
    return (
        Section(
            "axes",
            "Stiffness of the tool along x, y, z",
            ("worst pose", "median pose", "best pose"),
            tuple(rows),
            note,
        ),
        Section(
            "axes-parts",
            "Stiffness along x, y, z by part",
            tuple(f"along {axis}" for axis in AXES),
            parts,
            alone,
        ),
    )


def axes_sentence(survey: Survey, known: States) -> str:
    """Return the sentence of the headline on the stiffness along x, y and z at the worst poses."""
    texts = [str(_stiffness(survey, float(each))) for each in _compliance(survey).max(axis=0)]
    most = "at most " if known.lower_bound else ""
    return (
        f"Along x, y, z the tool's stiffness is {most}{', '.join(texts)}, each at its worst pose."
    )


def axes_cards(survey: Survey, known: States) -> list[Card]:
    """Return a card for each axis, with the stiffness at the worst pose."""
    sign = "≤ " if known.lower_bound else ""
    values = _compliance(survey)
    return [
        Card(
            f"stiffness along {axis}",
            f"{sign}{_stiffness(survey, float(own.max()))}",
            f"worst pose {own.argmax()}; median {_stiffness(survey, float(np.median(own)))}",
        )
        for axis, own in zip(AXES, values.T, strict=True)
    ]


def _stiffness(survey: Survey, compliance: float, samples: str = "") -> Cell:
    """Return the stiffness for a compliance in m/N, in N/µm, for a soft arm all in N/mm; infinite
    for a rigid direction.
    """
    unit = "N/mm" if survey.axis_compliance.max() > _SOFT else "N/µm"
    return (
        Cell(1 / compliance, unit, samples=samples)
        if compliance
        else Cell(math.inf, unit, samples=samples, words="rigid")
    )


def _compliance(survey: Survey) -> Floats:
    """Return the compliance (pose, axis), m/N, zero where it is rounding."""
    return _without_rounding(survey, survey.axis_compliance)


def _without_rounding(survey: Survey, compliance: Floats) -> Floats:
    return np.where(compliance > _RIGID * survey.axis_compliance.max(), compliance, 0.0)


def _at(survey: Survey, index: int) -> str:
    return (
        f"pose {index}: {joint_values(survey.arm, survey.poses.q[index])}, "
        f"{tool_place(survey.tool_positions[index])}"
    )
