"""Compliance of an arm at rest over the poses, along the base's axes, and by part: tables,
sentences, cards and notes.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.mechanism.elastostatics import elastic_terms
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.joint_values import joint_values, tool_place
from lostmotion.reporting.provenance import at_least
from lostmotion.reporting.sheet import Card, Cell, length, table

if TYPE_CHECKING:
    from lostmotion.error_model.provenance import States
    from lostmotion.loads.survey import Survey
    from lostmotion.reporting.sheet import Section
    from lostmotion.spatial import Floats

AXES: Final = "xyz"
_DIRECTION_DIGITS: Final = 2
# Smaller shares of the largest compliance are rounding.
_NOTHING: Final = 1e-9
# Below this share of the largest compliance a direction, or a part in it, is rigid.
_RIGID: Final = 1e-6
# m/N; arms that are softer along an axis, below 0.01 N/µm, are stated in N/mm.
_SOFT: Final = 1e-4
# Largest asymmetry of the compliance matrix that is not reported.
_RECIPROCAL: Final = 0.01


def compliance_sections(survey: Survey, counted: str) -> list[Section]:
    """Return the tables of compliance; none for a rigid arm."""
    if not survey.parts:
        return []
    return [
        _axes(survey, counted),
        _axes_by_part(survey),
        _map(survey, counted),
        _ellipsoid(survey),
        _shares(survey, counted),
    ]


def compliance_sentences(survey: Survey, known: States) -> list[str]:
    """Return the sentences of the headline on compliance and stiffness; none for a rigid arm."""
    if not survey.parts:
        return []
    part = short_name(survey.parts[int(survey.softest_shares.argmax())])
    largest = Cell(float(survey.max_compliance[survey.softest_pose]), "µm/N")
    texts = [str(_along_axis(survey, float(each))) for each in _compliance(survey).max(axis=0)]
    most = "at most " if known.lower_bound else ""
    sentences = [
        (
            f"The largest compliance is {at_least(largest, known)}; {part} contributes "
            f"{100 * survey.softest_shares.max():.0f} % at that pose, mean over directions."
        ),
        f"Along x, y, z the tool's stiffness is {most}{', '.join(texts)}, each at its worst pose.",
    ]
    if survey.payload_deflection is not None:
        deflection = length(float(survey.payload_deflection.max()))
        sentences.append(
            f"The payload's weight deflects the tool by {at_least(deflection, known)} at the worst "
            "pose."
        )
    return sentences


def compliance_cards(survey: Survey, known: States) -> list[Card]:
    """Return the cards of compliance, stiffness by axis at the worst pose, and deflection."""
    if not survey.parts:
        return []
    largest = float(survey.max_compliance[survey.softest_pose])
    sign = "≤ " if known.lower_bound else ""
    out = [
        Card(
            "largest compliance",
            str(Cell(largest, "µm/N")),
            f"pose {survey.softest_pose}",
            limited_as="error",
        ),
        Card("stiffness there", f"{sign}{_stiffness(largest)}", "tool free to rotate"),
        *(
            Card(
                f"stiffness along {axis}",
                f"{sign}{_along_axis(survey, float(own.max()))}",
                f"worst pose {own.argmax()}; median {_along_axis(survey, float(np.median(own)))}",
            )
            for axis, own in zip(AXES, _compliance(survey).T, strict=True)
        ),
    ]
    if survey.payload_deflection is not None:
        out.append(
            Card(
                "deflection by the payload",
                str(length(float(survey.payload_deflection.max()))),
                f"largest, {survey.arm.payload.mass:g} kg",
                limited_as="error",
            )
        )
    return out


def compliance_facts(survey: Survey) -> dict[str, Any]:
    """Return the compliance matrix at the most compliant pose as plain data; empty for a rigid
    arm.
    """
    if not survey.parts:
        return {}
    return {
        "compliance_at_softest_pose": {
            "pose": survey.softest_pose,
            "order": "rotation x y z, displacement x y z; rad and m per N m and N",
            "values": survey.compliance.tolist(),
        }
    }


def compliance_notes(survey: Survey) -> list[str]:
    """Return the notes on parts that are assumed rigid, and on an asymmetric matrix."""
    return [*_rigid(survey), *_reciprocity_notes(survey)]


def _rigid(survey: Survey) -> list[str]:
    """Return a note that names the parts assumed rigid because the file does not specify their
    compliance.
    """
    if not survey.parts:
        return ["every part is assumed rigid: there is no compliance to report"]
    arm = survey.arm
    soft = {(of.kind, of.place) for of in elastic_terms(arm)}
    closed_loop = [
        joint.name
        for joint in arm.driven
        if joint.encoder is not None and joint.encoder.side == "output"
    ]
    unspecified: dict[str, list[str]] = {"gearboxes": [], "bearings": [], "links": []}
    for joint, places in zip(arm.joints, arm.tree.joints, strict=True):
        moves = arm.tree.places[places.moved].joint is not None
        if moves and joint.name not in closed_loop and ("gearbox", places.moved) not in soft:
            unspecified["gearboxes"].append(joint.name)
        if moves and ("bearing", places.moved) not in soft:
            unspecified["bearings"].append(joint.name)
        if joint.link.reach and not joint.link.rigid and ("link", places.tip) not in soft:
            unspecified["links"].append(joint.name)
    rigid = ([] if ("base", 0) in soft else ["the base"]) + [
        f"{kind} of {', '.join(names)}" for kind, names in unspecified.items() if names
    ]
    notes = [f"compliance not specified, assumed rigid: {'; '.join(rigid)}"] if rigid else []
    return notes + (
        [
            (
                f"gearboxes of {', '.join(closed_loop)} add no compliance: an encoder on the "
                "output closes the position loop"
            )
        ]
        if closed_loop
        else []
    )


def _reciprocity_notes(survey: Survey) -> list[str]:
    """Return a note where tabulated bearing springs make the compliance matrix asymmetric beyond
    `_RECIPROCAL`.
    """
    worst = float(survey.asymmetry.max()) if survey.parts else 0.0
    if not worst > _RECIPROCAL:
        return []
    middle = float(np.median(survey.asymmetry))
    size = f"{100 * worst:.1f} % (median over poses {100 * middle:.2g} %)"
    return [
        (
            f"the compliance matrix is asymmetric by up to {size}: an estimate of the uncertainty "
            "of the tabulated bearing stiffness"
        )
    ]


def pose_name(survey: Survey, index: int) -> str:
    """Return a pose's number and joint values as text."""
    return f"pose {index}: {joint_values(survey.arm, survey.poses.q[index])}"


def _stiffness(compliance: float) -> Cell:
    """Return the stiffness for a compliance (m/N), in a unit that suits its size."""
    unit = "N/mm" if compliance > 1e-6 else "N/µm"  # noqa: PLR2004 - where people change units
    return Cell(1 / compliance if compliance else math.inf, unit)


def _along_axis(survey: Survey, compliance: float, samples: str = "") -> Cell:
    """Return the stiffness for a compliance in m/N, in N/µm, for a soft arm all in N/mm; infinite
    for a rigid direction.
    """
    unit = "N/mm" if survey.axis_compliance.max() > _SOFT else "N/µm"
    if compliance:
        return Cell(1 / compliance, unit, samples=samples)
    return Cell(math.inf, unit, samples=samples, words="rigid")


def _compliance(survey: Survey) -> Floats:
    """Return the compliance (pose, axis), m/N, zero where it is rounding."""
    return _without_rounding(survey, survey.axis_compliance)


def _without_rounding(survey: Survey, compliance: Floats) -> Floats:
    return np.where(compliance > _RIGID * survey.axis_compliance.max(), compliance, 0.0)


def _axes(survey: Survey, counted: str) -> Section:
    rows = []
    for axis, own in zip(AXES, _compliance(survey).T, strict=True):
        worst, best = int(own.argmax()), int(own.argmin())
        at = f"{pose_name(survey, worst)}, {tool_place(survey.tool_positions[worst])}"
        same = np.ptp(own) <= _RIGID * own.max()
        figures = (own[worst], np.median(own), own[best])
        cells = (_along_axis(survey, float(each), counted) for each in figures)
        note = "" if same else f"worst at {at}; best at pose {best}"
        rows.append((f"along {axis}", *cells, note))
    return table(
        "axes",
        "Stiffness of the tool along x, y, z",
        ("worst pose", "median pose", "best pose"),
        rows,
        "force on the tool point along an axis of the base over its displacement along the "
        "same axis, tool free to rotate; linearised at the arm's "
        "own load, clearances closed",
    )


def _axes_by_part(survey: Survey) -> Section:
    at = [f"pose {index}" for index in survey.axis_worst]
    by_part = _without_rounding(survey, survey.axis_parts).T
    return table(
        "axes-parts",
        "Stiffness along x, y, z by part",
        tuple(f"along {axis}" for axis in AXES),
        [
            (
                short_name(name),
                *(_along_axis(survey, float(c), here) for c, here in zip(own, at, strict=True)),
            )
            for name, own in zip(survey.parts, by_part, strict=True)
        ],
        "each at the worst pose of its axis; in series they give the stiffness there: "
        "compliances, the inverses, add. rigid: below a millionth of it",
    )


def _map(survey: Survey, counted: str) -> Section:
    largest, mean = survey.max_compliance, survey.mean_compliance
    lines = (
        ("most compliant direction, worst pose", largest.max(), survey.softest_pose),
        ("most compliant direction, median over poses", np.median(largest), None),
        ("most compliant direction, best pose", largest.min(), int(largest.argmin())),
        ("mean over directions, worst pose", mean.max(), int(mean.argmax())),
        ("mean over directions and poses", mean.mean(), None),
    )
    note = "linearised at the arm's own load, clearances closed"
    if survey.payload_deflection is not None:
        most = int(survey.payload_deflection.argmax())
        note += (
            f"; the payload's weight, {survey.arm.payload.mass:g} kg, deflects the tool by "
            f"{length(float(survey.payload_deflection.max()))} at most "
            f"(pose {most}), by {length(float(survey.payload_deflection.mean()))} on average "
            "over the poses"
        )
    return table(
        "map",
        "Compliance over the poses",
        {"compliance": "µm/N", "stiffness": ""},
        [
            (label, value, _stiffness(value), "" if at is None else pose_name(survey, at))
            for label, value, at in lines
        ],
        note,
        samples=counted,
    )


def _ellipsoid(survey: Survey) -> Section:
    rows: list[tuple[Any, ...]] = []
    least = _NOTHING * survey.translational.values[0, 0]
    for ellipsoid, what in (
        (survey.translational, "free to rotate"),
        (survey.guided, "rotation constrained"),
    ):
        for k, value in enumerate(ellipsoid.values[0]):
            shown = float(value) if value > least else 0.0
            axis = _direction(ellipsoid.directions[0, :, k])
            rows.append((f"{what}, {k + 1}", shown, _stiffness(shown), f"along {axis}"))
    least = _NOTHING * survey.rotational.values[0, 0]
    for k, value in enumerate(survey.rotational.values[0]):
        shown = float(value) if value > least else 0.0
        rows.append(
            (
                f"rotation under a moment, {k + 1}",
                Cell(shown, "arcmin/(N m)"),
                Cell(1 / shown if shown else math.inf, "N m/arcmin"),
                f"about {_direction(survey.rotational.directions[0, :, k])}",
            )
        )
    return table(
        "ellipsoid",
        "Compliance ellipsoid at the most compliant pose",
        {"compliance": "µm/N", "stiffness": ""},
        rows,
        f"principal directions at {pose_name(survey, survey.softest_pose)}",
        samples=f"pose {survey.softest_pose}",
    )


def _direction(axis: Floats) -> str:
    """Return an axis as text, its sign chosen so that the largest component is positive."""
    signed = np.round(axis * np.sign(axis[np.abs(axis).argmax()]), _DIRECTION_DIGITS) + 0.0
    return f"({', '.join(f'{each:.{_DIRECTION_DIGITS}f}' for each in signed)})"


def _shares(survey: Survey, counted: str) -> Section:
    here = f"pose {survey.softest_pose}"
    return table(
        "shares",
        "Compliance by part",
        {"mean over poses": "%", "most compliant pose": "%"},
        [
            (
                short_name(survey.parts[k]),
                survey.shares[k],
                Cell(float(survey.softest_shares[k]), "%", samples=here),
            )
            for k in np.argsort(-survey.shares, kind="stable")
        ],
        "share of the compliance along a force, mean over directions",
        samples=counted,
    )
