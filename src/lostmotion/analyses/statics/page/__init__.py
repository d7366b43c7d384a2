"""Result and sheet of an arm at rest: holding torques and their causes, suitable reducers, bearing
loads, compliance, and the largest payload where it was asked for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.result import Result
from lostmotion.analyses.statics.page.compliance import (
    compliance_cards,
    compliance_facts,
    compliance_notes,
    compliance_sections,
    compliance_sentences,
    pose_name,
)
from lostmotion.analyses.statics.page.payload import (
    payload_cards,
    payload_facts,
    payload_section,
    payload_sentences,
)
from lostmotion.catalogue.gearboxes import gearboxes
from lostmotion.catalogue.search import Criteria, search, searchable_figures
from lostmotion.error_model.provenance import NOT_DESCRIBED, of_compliance, states
from lostmotion.loads.survey import Survey
from lostmotion.mechanism.load_causes import CAUSES
from lostmotion.reporting.arm_sheet import bounded_cards, with_arm
from lostmotion.reporting.first_order import with_falls
from lostmotion.reporting.provenance import assumed_value_sentences, caveats
from lostmotion.reporting.sheet import Card, Cell, Sheet, several, table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.catalogue.gearbox_row import GearboxRow
    from lostmotion.error_model.provenance import States
    from lostmotion.loads.payload import MaxPayload
    from lostmotion.mechanism.holding_torques import DriveLoad, JointLoad
    from lostmotion.parts.moving_joint import MovingJoint
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Section

_SHOWN: Final = 3
# Smaller torques (N m, N) are rounding.
_NOTHING: Final = 1e-9
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


@dataclass(frozen=True, repr=False)
class Statics(Survey, Result):
    """Loads and compliance of an arm: every attribute of `Survey`.

    `reducers` are the user's rows that are searched besides the catalogue, `payload` is the largest
    payload where it was asked for.
    """

    reducers: Sequence[GearboxRow] = ()
    payload: MaxPayload | None = None

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        return statics_sheet(self, self.reducers, self.payload)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.statics.page.plots import statics_plots

        return statics_plots(self, self.payload)


def statics_sheet(
    survey: Survey, own: Sequence[GearboxRow] = (), payload: MaxPayload | None = None
) -> Sheet:
    """Return the sheet of an arm at rest; `own` are the user's reducers, which are searched besides
    the catalogue.
    """
    arm, counted = survey.arm, f"{several(len(survey.poses), 'pose')}, {survey.poses.law}"
    known = states(arm)
    elastic = of_compliance(known)
    tilt = "" if survey.tilt is None else f", base tilt {_tilt(survey)}"
    sheet = Sheet(
        subject="statics and compliance",
        verdict=with_falls(_verdict(survey, payload, known), survey.arm),
        cards=bounded_cards(
            [
                *payload_cards(arm, payload, known),
                *_cards(survey),
                *compliance_cards(survey, elastic),
            ],
            elastic,
        ),
        sections=(
            *payload_section(arm, payload, known),
            _torques(survey, counted),
            _causes(survey, counted),
            _reducers(survey, own),
            _bearings(survey, counted),
            *compliance_sections(survey, counted),
        ),
        counts=counted + tilt,
        notes=tuple(compliance_notes(survey)),
        words=_WORDS,
        source=f"{counted}. The same file, version, poses and tilt give the same bytes.",
        facts={
            "poses": {"count": len(survey.poses), "law": survey.poses.law},
            "tilt_rad": survey.tilt,
            **payload_facts(arm, payload),
            **compliance_facts(survey),
        },
    )
    return with_arm(sheet, arm, known, poses=survey.poses)


def _verdict(survey: Survey, payload: MaxPayload | None, known: States) -> str:
    elastic = of_compliance(known)
    behind = elastic if payload is None else known
    compliance = compliance_sentences(survey, elastic)
    errors = compliance or (payload is not None and len(payload.limits) > 1)
    return " ".join(
        [
            *payload_sentences(survey.arm, payload, known),
            *_torque_sentence(survey),
            *compliance,
            *(
                # loads and ratings alone rest on no described error
                (caveats(behind, missing=False) if errors else assumed_value_sentences(known))
                if known.described
                else [f"{NOT_DESCRIBED[0].upper()}{NOT_DESCRIBED[1:]}."]
            ),
        ]
    )


def _torque_sentence(survey: Survey) -> list[str]:
    turning = [node for node in survey.joint_loads if node.unit == "N m"]
    if not turning:
        return []
    level = max(turning, key=lambda node: abs(node.nominal.value))
    tilted = max(turning, key=lambda node: abs(node.required.value))
    tilt = (
        "at any tilt of the base"
        if survey.tilt is None
        else f"with the base tilted by {_tilt(survey)}"
    )
    standing, most = (Cell(abs(load.value), "N m") for load in (level.nominal, tilted.required))
    if standing.value <= _NOTHING:
        return [f"No joint holds a torque as the base stands; {tilted.joint} has {most} {tilt}."]
    both = (
        f"{standing}, as the base stands and {tilt}"
        if str(standing) == str(most)
        else f"{standing} as the base stands, {most} "
        f"{'' if tilted is level else f'at {tilted.joint} '}{tilt}"
    )
    return [f"Joint {level.joint} has the largest holding torque: {both}."]


def _tilt(survey: Survey) -> str:
    return f"up to {_degrees(survey.tilt or 0.0)}"


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.3g}°"


def _cards(survey: Survey) -> list[Card]:
    """Return the cards of the two most loaded joints."""
    loaded = sorted(survey.joint_loads, key=lambda node: (node.unit, abs(node.required.value)))
    return [
        Card(
            f"holding {'torque' if node.unit == 'N m' else 'force'} {node.joint}",
            str(Cell(abs(node.required.value), node.unit)),
            "any tilt" if survey.tilt is None else f"tilt {_tilt(survey)}",
        )
        for node in loaded[::-1][:2]
    ]


def _cases(survey: Survey, node: JointLoad) -> dict[str, DriveLoad]:
    tilted = {} if node.within_tilt is None else {f"tilt {_tilt(survey)}": node.within_tilt}
    return {"nominal base": node.nominal, **tilted, "any tilt": node.any_tilt}


def _torques(survey: Survey, counted: str) -> Section:
    columns = tuple(_cases(survey, survey.joint_loads[0]))
    last = columns[-1] if survey.tilt is None else columns[1]
    rows = [
        (
            node.joint,
            *(
                Cell(load.value if load is node.nominal else abs(load.value), node.unit)
                for load in _cases(survey, node).values()
            ),
            pose_name(survey, node.required.index) if abs(node.required.value) > _NOTHING else "",
        )
        for node in survey.joint_loads
    ]
    return table(
        "torques",
        "Static holding torque of each drive",
        columns,
        rows,
        "largest magnitude over the sampled poses, exact over tilts; the pose is that of "
        f"'{last}'. For the nominal base the sign is that of the "
        "drive torque. Without acceleration",
        samples=counted,
    )


def _causes(survey: Survey, counted: str) -> Section:
    present = [
        cause
        for cause in CAUSES
        if any(cause in node.nominal.by_cause for node in survey.joint_loads)
    ]
    rows = []
    for node in survey.joint_loads:
        for name, load in _cases(survey, node).items():
            if abs(load.value) <= _NOTHING:
                continue
            figures = (load.value, *(load.by_cause[cause] for cause in present))
            sign = math.copysign(1.0, load.value)
            tilt = "" if load is node.nominal else f", tilt {_degrees(load.tilt)}"
            cells = (Cell(sign * each, node.unit) for each in figures)
            rows.append((f"{node.joint}, {name}", *cells, f"pose {load.index}{tilt}"))
    return table(
        "causes",
        "Holding torque by cause",
        ("total", *present),
        rows,
        "negative: this weight relieves the drive. Tilt: the smallest tilt of the base with this "
        "torque",
        samples=counted,
    )


def _reducers(survey: Survey, own: Sequence[GearboxRow]) -> Section:
    known = [*own, *gearboxes()]
    lines = [
        _suitable(joint, node, known)
        for joint, node in zip(survey.arm.driven, survey.joint_loads, strict=True)
    ]
    unrated = max(count for _, count in lines)
    tilts = "any tilt" if survey.tilt is None else "the worst tilt within the stated range"
    note = f"static torque at {tilts}, without allowance for acceleration, shock loads and life"
    note += f". {unrated} rows without a rated torque are excluded" if unrated else ""
    columns = ("required", "rated, as stated")
    return table("reducers", "Suitable reducers", columns, [row for row, _ in lines], note)


def _suitable(
    joint: MovingJoint[Any, Any, Any], node: JointLoad, known: Sequence[GearboxRow]
) -> tuple[tuple[Any, ...], int]:
    """Return the row of the reducers that suit a joint, and how many were excluded as unrated."""
    gearbox, required = joint.gearbox, abs(node.required.value)
    stated = None if gearbox is None else gearbox.rated_torque
    rated = Cell(math.nan if stated is None else float(stated), node.unit, stated=True)
    row = (node.joint, Cell(required, node.unit), rated)
    if node.unit != "N m":
        return (*row, "prismatic joint: the catalogue rates reducers by torque"), 0
    ratio = None if gearbox is None or not gearbox.states_ratio else abs(float(gearbox.ratio))
    answer = search(known, Criteria(min_torque=max(required, _NOTHING), ratio=ratio))
    torques = {id(each): searchable_figures(each)["rated torque"] for each in answer.rows}
    names = ", ".join(
        f"{_name(each)} ({torques[id(each)]:.4g} N m)"
        for each in sorted(answer.rows, key=lambda each: torques[id(each)])[:_SHOWN]
    )
    of = "" if ratio is None else f" for the ratio {ratio:g}"
    choice = (
        f"{len(answer.rows)} in the catalogue{of}; the smallest: {names}"
        if names
        else f"none in the catalogue{of} is rated for it"
    )
    weak = stated is not None and stated < required
    note = f"{'the stated reducer is rated below this; ' if weak else ''}{choice}"
    return (*row, note), len(answer.not_stated.get("rated torque", ()))


def _name(row: GearboxRow) -> str:
    ratio = "" if row.typical_ratio is None else f" ratio {row.ratios}"
    return f"{row.models[0]}{ratio}"


def _bearings(survey: Survey, counted: str) -> Section:
    rows = [
        (
            node.joint,
            node.moment if node.moment > _NOTHING else 0.0,
            node.moment_any_tilt,
            node.force,
            f"poses {node.moment_index}, {node.moment_any_tilt_index}, {node.force_index}",
        )
        for node in survey.joint_loads
    ]
    note = (
        "tilting moment perpendicular to the joint axis, the whole moment on a prismatic "
        "joint; largest of the sampled poses"
    )
    if any(survey.arm.payload.force) or any(survey.arm.payload.moment):
        note += (
            ". At any tilt: upper bound, because the direction of the process force follows the arm"
        )
    return table(
        "bearings",
        "Static load on each joint's bearing",
        {"moment, nominal base": "N m", "moment, any tilt": "N m", "force, nominal base": "N"},
        rows,
        note,
        samples=counted,
    )
