"""Tables of an arm at rest: holding torques and their causes, suitable reducers, bearing loads,
compliance.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.statics.axes_tables import axes_cards, axes_sections, axes_sentence
from lostmotion.analyses.statics.payload_tables import (
    payload_cards,
    payload_facts,
    payload_section,
    payload_sentences,
)
from lostmotion.catalogue.gearboxes import gearboxes
from lostmotion.catalogue.search import Criteria, search, searchable_figures
from lostmotion.error_model.provenance import NOT_DESCRIBED, of_compliance, states
from lostmotion.mechanism.elastostatics import elastic_terms
from lostmotion.mechanism.load_causes import CAUSES
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.provenance import (
    at_least,
    bounded_cards,
    caveats,
    provenance_facts,
    provenance_sections,
)
from lostmotion.reporting.sheet import Card, Cell, Row, Section, Sheet, length, several
from lostmotion.reporting.warnings import arm_warnings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.analyses.statics.payload import MaxPayload
    from lostmotion.analyses.statics.survey import Survey
    from lostmotion.catalogue.gearbox_row import GearboxRow
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.holding_torques import DriveLoad, JointLoad
    from lostmotion.spatial import Floats

_SHOWN: Final = 3
_DIRECTION_DIGITS: Final = 2
# Smaller shares of the largest compliance, and smaller torques (N m, N), are rounding.
_NOTHING: Final = 1e-9
# Largest asymmetry of the compliance matrix that is not reported.
_RECIPROCAL: Final = 0.01
_WORDS: Final = (
    (
        "holding torque",
        "drive torque against gravity and the process force at rest; a force on a prismatic joint.",
    ),
    (
        "any tilt",
        (
            "the worst over every direction of gravity in the base's axes: on a slope, on a wall, "
            "under a ceiling."
        ),
    ),
    (
        "compliance",
        (
            "displacement of the tool point per newton, linearised at the arm's own load. Play is "
            "not included."
        ),
    ),
    (
        "principal direction",
        "a force along it moves the tool point along it only. x, y, z are the base's axes.",
    ),
    (
        "rotation constrained",
        "for a tool that is guided and cannot rotate; free to rotate: the force also rotates it.",
    ),
    (
        "share",
        (
            "part of the compliance along a force, mean over all directions of the force. Shares "
            "add to 100 %."
        ),
    ),
)


def statics_sheet(
    survey: Survey, own: Sequence[GearboxRow] = (), payload: MaxPayload | None = None
) -> Sheet:
    """Return the sheet of an arm at rest; `own` are the user's reducers, which are searched besides
    the catalogue.
    """
    counted = f"{several(len(survey.poses), 'pose')}, {survey.poses.law}"
    known = states(survey.arm)
    elastic = of_compliance(known)
    sections = [
        *payload_section(survey.arm, payload, known),
        _torques(survey, counted),
        _causes(survey, counted),
    ]
    sections += [_reducers(survey, own), _bearings(survey, counted)]
    if survey.parts:
        sections += [
            *axes_sections(survey, counted),
            _map(survey, counted),
            _ellipsoid(survey),
            _shares(survey, counted),
        ]
    return Sheet(
        name=survey.arm.name,
        subject="statics and compliance",
        verdict=_verdict(survey, payload, known),
        cards=bounded_cards(
            _cards(survey, payload, known),
            elastic,
            ("largest compliance", "deflection by the payload"),
        ),
        sections=(*sections, *provenance_sections(known)),
        counts=counted
        + ("" if survey.tilt is None else f", base tilt up to {_degrees(survey.tilt)}"),
        warnings=arm_warnings(survey.arm, survey.poses),
        notes=(*survey.arm.remarks, *_rigid(survey), *_reciprocity_notes(survey)),
        words=_WORDS,
        source=f"{counted}. The same file, version, poses and tilt give the same bytes.",
        facts={
            "arm": survey.arm.name,
            "poses": {"count": len(survey.poses), "law": survey.poses.law},
            "tilt_rad": survey.tilt,
            **provenance_facts(known),
            **payload_facts(survey.arm, payload),
            **({"compliance_at_softest_pose": _matrix(survey)} if survey.parts else {}),
        },
    )


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


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.3g}°"


def _pose(survey: Survey, index: int) -> str:
    """Return a pose's number and joint values as text."""
    return f"pose {index}: {joint_values(survey.arm, survey.poses.q[index])}"


def _matrix(survey: Survey) -> dict[str, Any]:
    """Return the compliance matrix at the most compliant pose as plain data."""
    return {
        "pose": survey.softest_pose,
        "order": "rotation x y z, displacement x y z; rad and m per N m and N",
        "values": survey.compliance.tolist(),
    }


def _micro_per_newton(value: float, samples: str = "") -> Cell:
    return Cell(value, "µm/N", samples=samples)


def _stiffness(value: float, samples: str = "") -> Cell:
    """Return the stiffness for a compliance (m/N), in a unit that suits its size."""
    if value > 1e-6:  # noqa: PLR2004 - where people change units
        return Cell(1 / value, "N/mm", samples=samples)
    return Cell(1 / value if value else math.inf, "N/µm", samples=samples)


def _verdict(survey: Survey, payload: MaxPayload | None, known: States) -> str:
    turning = [node for node in survey.joint_loads if node.unit == "N m"]
    elastic = of_compliance(known)
    sentences = payload_sentences(survey.arm, payload, known)
    if turning:
        level, tilted = (
            max(turning, key=lambda node: abs(node.nominal.value)),
            max(turning, key=lambda node: abs(node.required.value)),
        )
        tilt = (
            "at any tilt of the base"
            if survey.tilt is None
            else f"with the base tilted by up to {_degrees(survey.tilt)}"
        )
        at = "" if tilted is level else f"at {tilted.joint} "
        standing, most = (Cell(abs(load.value), "N m") for load in (level.nominal, tilted.required))
        same = str(standing) == str(most)
        both = (
            f"{standing}, as the base stands and {tilt}"
            if same
            else f"{standing} as the base stands, {most} {at}{tilt}"
        )
        sentences.append(
            f"Joint {level.joint} has the largest holding torque: {both}."
            if standing.value > _NOTHING
            else f"No joint holds a torque as the base stands; {tilted.joint} has {most} {tilt}."
        )
    if survey.parts:
        part = short_name(survey.parts[int(survey.softest_shares.argmax())])
        sentences.append(
            "The largest compliance is "
            f"{at_least(_micro_per_newton(float(survey.max_compliance[survey.softest_pose])), elastic)}; "  # noqa: E501
            f"{part} contributes {100 * survey.softest_shares.max():.0f} % at that pose, mean "
            "over directions."
        )
    if survey.parts:
        sentences.append(axes_sentence(survey, elastic))
    if survey.payload_deflection is not None and survey.parts:
        sentences.append(
            "The payload's weight deflects the tool by up to "
            f"{at_least(length(float(survey.payload_deflection.max())), elastic)}."
        )
    behind = elastic if payload is None else known
    return " ".join(
        [
            *sentences,
            *(
                caveats(behind, missing=False)
                if known.described
                else [f"{NOT_DESCRIBED[0].upper()}{NOT_DESCRIBED[1:]}."]
            ),
        ]
    )


def _cards(survey: Survey, payload: MaxPayload | None, known: States) -> list[Card]:
    out = payload_cards(survey.arm, payload, known)
    for node in sorted(survey.joint_loads, key=lambda node: (node.unit, abs(node.required.value)))[
        ::-1
    ][:2]:
        tilt = "any tilt" if survey.tilt is None else f"tilt up to {_degrees(survey.tilt)}"
        out.append(
            Card(
                f"holding torque {node.joint}"
                if node.unit == "N m"
                else f"holding force {node.joint}",
                str(Cell(abs(node.required.value), node.unit)),
                tilt,
            )
        )
    if survey.parts:
        largest = float(survey.max_compliance[survey.softest_pose])
        out += [
            Card(
                "largest compliance", str(_micro_per_newton(largest)), f"pose {survey.softest_pose}"
            ),
            Card("stiffness there", str(_stiffness(largest)), "tool free to rotate"),
            *axes_cards(survey, of_compliance(known)),
        ]
    if survey.payload_deflection is not None and survey.parts:
        out.append(
            Card(
                "deflection by the payload",
                str(length(float(survey.payload_deflection.max()))),
                f"largest, {survey.arm.payload.mass:g} kg",
            )
        )
    return out


def _cases(survey: Survey, node: JointLoad) -> list[tuple[str, DriveLoad]]:
    tilted = (
        []
        if node.within_tilt is None or survey.tilt is None
        else [(f"tilt up to {_degrees(survey.tilt)}", node.within_tilt)]
    )
    return [("nominal base", node.nominal), *tilted, ("any tilt", node.any_tilt)]


def _torques(survey: Survey, counted: str) -> Section:
    rows = [
        Row(
            node.joint,
            tuple(
                Cell(
                    load.value if load is node.nominal else abs(load.value),
                    node.unit,
                    samples=counted,
                )
                for _, load in _cases(survey, node)
            ),
            _pose(survey, node.required.index) if abs(node.required.value) > _NOTHING else "",
        )
        for node in survey.joint_loads
    ]
    columns = tuple(name for name, _ in _cases(survey, survey.joint_loads[0]))
    last = columns[-1] if survey.tilt is None else columns[1]
    note = (
        "largest magnitude over the sampled poses, exact over tilts; the pose is that of "
        f"'{last}'. For the nominal base the sign is that of the "
        "drive torque. Without acceleration"
    )
    return Section("torques", "Static holding torque of each drive", columns, tuple(rows), note)


def _causes(survey: Survey, counted: str) -> Section:
    present = [
        cause
        for cause in CAUSES
        if any(cause in node.nominal.by_cause for node in survey.joint_loads)
    ]
    rows = []
    for node in survey.joint_loads:
        for name, load in _cases(survey, node):
            if abs(load.value) <= _NOTHING:
                continue
            sign = math.copysign(1.0, load.value)
            figures = [
                Cell(sign * each, node.unit, samples=counted)
                for each in (load.value, *(load.by_cause[cause] for cause in present))
            ]
            tilt = "" if load is node.nominal else f", tilt {_degrees(load.tilt)}"
            rows.append(Row(f"{node.joint}, {name}", tuple(figures), f"pose {load.index}{tilt}"))
    note = (
        "negative: this weight relieves the drive. Tilt: the smallest tilt of the base with this "
        "torque"
    )
    return Section("causes", "Holding torque by cause", ("total", *present), tuple(rows), note)


def _reducers(survey: Survey, own: Sequence[GearboxRow]) -> Section:
    rows, unrated = [], 0
    known = [*own, *gearboxes()]
    for joint, node in zip(survey.arm.driven, survey.joint_loads, strict=True):
        required = abs(node.required.value)
        stated = joint.gearbox.rated_torque if joint.gearbox is not None else None
        rated = (
            Cell(math.nan, node.unit)
            if stated is None
            else Cell(float(stated), node.unit, stated=True)
        )
        figures = (Cell(required, node.unit), rated)
        if node.unit != "N m":
            rows.append(
                Row(node.joint, figures, "prismatic joint: the catalogue rates reducers by torque")
            )
            continue
        ratio = (
            abs(float(joint.gearbox.ratio))
            if joint.gearbox is not None and joint.gearbox.states_ratio
            else None
        )
        answer = search(known, Criteria(min_torque=max(required, _NOTHING), ratio=ratio))
        unrated = max(unrated, len(answer.not_stated.get("rated torque", ())))
        suitable = sorted(answer.rows, key=lambda row: searchable_figures(row)["rated torque"])
        names = ", ".join(
            f"{_name(row)} ({searchable_figures(row)['rated torque']:.4g} N m)"
            for row in suitable[:_SHOWN]
        )
        of = "" if ratio is None else f" for the ratio {ratio:g}"
        choice = (
            f"{len(suitable)} in the catalogue{of}; the smallest: {names}"
            if suitable
            else f"none in the catalogue{of} is rated for it"
        )
        weak = (
            "the stated reducer is rated below this; "
            if stated is not None and stated < required
            else ""
        )
        rows.append(Row(node.joint, figures, weak + choice))
    tilts = "any tilt" if survey.tilt is None else "the worst tilt within the stated range"
    note = f"static torque at {tilts}, without allowance for acceleration, shock loads and life"
    note += f". {unrated} rows without a rated torque are excluded" if unrated else ""
    return Section(
        "reducers", "Suitable reducers", ("required", "rated, as stated"), tuple(rows), note
    )


def _name(row: GearboxRow) -> str:
    ratio = "" if row.typical_ratio is None else f" ratio {row.ratios}"
    return f"{row.models[0]}{ratio}"


def _bearings(survey: Survey, counted: str) -> Section:
    rows = [
        Row(
            node.joint,
            (
                Cell(_clean(node.moment), "N m", samples=counted),
                Cell(node.moment_any_tilt, "N m", samples=counted),
                Cell(node.force, "N", samples=counted),
            ),
            f"poses {node.moment_index}, {node.moment_any_tilt_index}, {node.force_index}",
        )
        for node in survey.joint_loads
    ]
    process = any(survey.arm.payload.force) or any(survey.arm.payload.moment)
    note = (
        "tilting moment perpendicular to the joint axis, the whole moment on a prismatic "
        "joint; largest of the sampled poses"
    ) + (
        ". At any tilt: upper bound, because the direction of the process force follows the arm"
        if process
        else ""
    )
    columns = ("moment, nominal base", "moment, any tilt", "force, nominal base")
    return Section("bearings", "Static load on each joint's bearing", columns, tuple(rows), note)


def _clean(moment: float) -> float:
    return moment if moment > _NOTHING else 0.0


def _map(survey: Survey, counted: str) -> Section:
    softest, stiffest = survey.softest_pose, int(survey.max_compliance.argmin())
    rows = [
        Row(label, (_micro_per_newton(value, counted), _stiffness(value, counted)), note)
        for label, value, note in (
            (
                "most compliant direction, worst pose",
                float(survey.max_compliance[softest]),
                _pose(survey, softest),
            ),
            (
                "most compliant direction, median over poses",
                float(np.median(survey.max_compliance)),
                "",
            ),
            (
                "most compliant direction, best pose",
                float(survey.max_compliance[stiffest]),
                _pose(survey, stiffest),
            ),
            (
                "mean over directions, worst pose",
                float(survey.mean_compliance.max()),
                _pose(survey, int(survey.mean_compliance.argmax())),
            ),
            ("mean over directions and poses", float(survey.mean_compliance.mean()), ""),
        )
    ]
    note = "linearised at the arm's own load, clearances closed"
    if survey.payload_deflection is not None:
        most = int(survey.payload_deflection.argmax())
        note += (
            f"; the payload's weight, {survey.arm.payload.mass:g} kg, deflects the tool by "
            f"{length(float(survey.payload_deflection.max()))} at most "
            f"(pose {most}), by {length(float(survey.payload_deflection.mean()))} on average "
            "over the poses"
        )
    return Section(
        "map", "Compliance over the poses", ("compliance", "stiffness"), tuple(rows), note
    )


def _ellipsoid(survey: Survey) -> Section:
    counted = f"pose {survey.softest_pose}"
    rows = []
    for ellipsoid, what in (
        (survey.translational, "free to rotate"),
        (survey.guided, "rotation constrained"),
    ):
        for k, value in enumerate(ellipsoid.values[0]):
            axis = _direction(ellipsoid.directions[0, :, k])
            shown = float(value) if value > _NOTHING * survey.translational.values[0, 0] else 0.0
            rows.append(
                Row(
                    f"{what}, {k + 1}",
                    (_micro_per_newton(shown, counted), _stiffness(shown, counted)),
                    f"along {axis}",
                )
            )
    for k, value in enumerate(survey.rotational.values[0]):
        shown = float(value) if value > _NOTHING * survey.rotational.values[0, 0] else 0.0
        figures = (
            Cell(shown, "arcmin/(N m)", samples=counted),
            Cell(1 / shown if shown else math.inf, "N m/arcmin", samples=counted),
        )
        rows.append(
            Row(
                f"rotation under a moment, {k + 1}",
                figures,
                f"about {_direction(survey.rotational.directions[0, :, k])}",
            )
        )
    note = f"principal directions at {_pose(survey, survey.softest_pose)}"
    return Section(
        "ellipsoid",
        "Compliance ellipsoid at the most compliant pose",
        ("compliance", "stiffness"),
        tuple(rows),
        note,
    )


def _direction(axis: Floats) -> str:
    """Return an axis as text, its sign chosen so that the largest component is positive."""
    signed = axis * np.sign(axis[np.abs(axis).argmax()])
    return (
        "("
        + ", ".join(
            f"{each:.{_DIRECTION_DIGITS}f}" for each in np.round(signed, _DIRECTION_DIGITS) + 0.0
        )
        + ")"
    )


def _shares(survey: Survey, counted: str) -> Section:
    order = np.argsort(-survey.shares, kind="stable")
    here = f"pose {survey.softest_pose}"
    rows = tuple(
        Row(
            short_name(survey.parts[k]),
            (
                Cell(float(survey.shares[k]), "%", samples=counted),
                Cell(float(survey.softest_shares[k]), "%", samples=here),
            ),
        )
        for k in order
    )
    return Section(
        "shares",
        "Compliance by part",
        ("mean over poses", "most compliant pose"),
        rows,
        "share of the compliance along a force, mean over directions",
    )
