"""ISO 9283 sheet: headline, cards, tables and notes of predicted robots, of a measured one, or of
both.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.iso9283.tables.labels import NO_SCATTER
from lostmotion.error_model.provenance import states
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.propagation.iso9283.cube import NAMES
from lostmotion.reporting.arm_sheet import bounded_sections
from lostmotion.reporting.first_order import checked, failure
from lostmotion.reporting.provenance import provenance_facts, provenance_sections
from lostmotion.reporting.sheet import Section, Sheet, several
from lostmotion.reporting.warnings import arm_warnings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.analyses.iso9283.comparison import ComparedFigure
    from lostmotion.analyses.iso9283.measured import MeasuredRobot
    from lostmotion.mechanism.warm_up import Drift
    from lostmotion.propagation.iso9283.cube import CommandedPoses
    from lostmotion.propagation.iso9283.robots import PredictedRobots
    from lostmotion.reporting.sheet import Card

# Sections of which every length is an error of the predicted robots.
_BOUNDED: Final = ("ap", "fitted", "rp", "either", "axes", "vap", "distance", "path")
# With fewer robots than this, fewer than three lie above the 95th percentile.
_FEW: Final = 60
_WORDS: Final = (
    (
        "predicted, never certified",
        (
            "characteristics by the definitions of ISO 9283:1998, for simulated robots of this "
            "design; a certificate needs the robot itself."
        ),
    ),
    (
        "AP_p",
        (
            "pose accuracy: distance of the barycentre (the mean of a robot's visits) from the "
            "commanded point (7.2.1)."
        ),
    ),
    (
        "best-fit frames",
        (
            "AP_p after a least-squares fit of the base frame (and of the tool frame, where "
            "orientations were measured)."
        ),
    ),
    (
        "RP_l",
        (
            "pose repeatability: mean distance of the visits from their barycentre plus three "
            "standard deviations of it (7.2.2)."
        ),
    ),
    (
        "thirty visits",
        (
            "RP_l of 30 visits is a sample estimate: for isotropic normal scatter mean 3.536 "
            "sigma, standard deviation 0.329; 3.616 for many visits."
        ),
    ),
    (
        "none described",
        (
            "no described error varies from visit to visit: no repeatability is predicted, which "
            "does not mean that it is zero."
        ),
    ),
    (
        "from either side",
        (
            "RP_l if joints arrive from either side at random, so that all backlash counts. In "
            "the standard's cycle each arrives from one."
        ),
    ),
    (
        "mean, 95th percentile",
        "over the simulated robots; at full payload where no load is stated.",
    ),
    ("worst", "the worst of the five poses of each robot."),
    ("a, b, c", "rotations about the base's x, y, z axes."),
    (
        "vAP_p",
        (
            "multi-directional pose accuracy: largest distance between the barycentres of "
            "approaches along the base's x, y and z (7.2.3)."
        ),
    ),
    (
        "A, R, B, E, M",
        (
            "ISO 230-2: range of mean ± two standard deviations over all positions (A) and at the "
            "worst (R); B is the difference of the sides."
        ),
    ),
    ("AD_p, RD", "accuracy and repeatability of the distance between P2 and P4 (7.3)."),
    (
        "AT_p, RT_p",
        (
            "path accuracy and repeatability, normal to the path, at its worst point (8.2, 8.3); "
            "AT_a to RT_c of its orientation. Quasi-static."
        ),
    ),
    ("100 %, 10 %", "share of the payload that the tool carries."),
    (
        "interval",
        "95 % confidence interval from the number of robots. A question mark: too few robots.",
    ),
)


def iso_sheet(
    predicted: PredictedRobots | None,
    drifted: Drift | None,
    measured: MeasuredRobot | None,
    compared: Sequence[ComparedFigure],
    commanded: CommandedPoses | None,
) -> Sheet:
    """Return the sheet of predicted robots, of a measured one, or of both side by side; arguments
    as the members of `Iso9283`.
    """
    from lostmotion.analyses.iso9283.tables.comparison import comparison_sections
    from lostmotion.analyses.iso9283.tables.headline import predicted_cards, predicted_verdict
    from lostmotion.analyses.iso9283.tables.measured import measured_facts, measured_sections
    from lostmotion.analyses.iso9283.tables.measured_headline import (
        command_warnings,
        duplicates_note,
        lost_warnings,
        measured_cards,
        measured_counts,
        measured_verdict,
        not_compared_notes,
        outlying_warnings,
        unused_notes,
    )
    from lostmotion.analyses.iso9283.tables.predicted import predicted_sections

    notes: tuple[str, ...] = ()
    if predicted is not None and measured is not None and not compared:
        notes = (
            (
                "not compared: no pose of the measured file has a commanded position under a "
                "load that was predicted"
            ),
        )
    sections: list[Section] = []
    cards: list[Card] = []
    verdict: list[str] = []
    facts: dict[str, Any] = {}
    counted: list[str] = []
    about: tuple[Section, ...] = ()
    doubts: tuple[str, ...] = ()
    name = "Measured robot"
    if predicted is not None:
        known = with_limits(
            states(predicted.arm), predicted.arm, predicted.cube.q, predicted.approach
        )
        # More limits count in the scatter from either side than in that from one side.
        either_known = with_limits(states(predicted.arm), predicted.arm, predicted.cube.q)
        sections += bounded_sections(predicted_sections(predicted, drifted), known, _BOUNDED)
        cards += predicted_cards(predicted, known, either_known)
        verdict.append(predicted_verdict(predicted, known, either_known))
        facts |= {**_facts(predicted), **provenance_facts(known)}
        about = provenance_sections(known)
        counted.append(
            f"{several(predicted.robots, 'robot')} x {several(predicted.cycles, 'cycle')} x 5 "
            f"poses, seed {predicted.seed}"
        )
        failed = failure(predicted.check, predicted.check.length, predicted.arm)
        name, notes = (
            predicted.arm.name,
            (
                *([failed] if failed and measured is not None else []),
                *predicted.arm.remarks,
                *_remarks(predicted),
                *notes,
            ),
        )
    if measured is not None:
        sections += [*comparison_sections(compared), *measured_sections(measured)]
        cards += measured_cards(measured, compared)
        verdict.append(measured_verdict(measured, compared, commanded))
        facts |= measured_facts(measured, compared)
        notes = (
            *unused_notes(measured.visits),
            *not_compared_notes(measured, predicted if compared else None, commanded),
            *notes,
        )
        doubts = (
            *command_warnings(measured, predicted),
            *outlying_warnings(measured),
            *lost_warnings(measured.visits),
        )
        if measured.visits.duplicates:
            notes = (*notes, duplicates_note(measured.visits))
        counted.append(measured_counts(measured))
    sheet = Sheet(
        name=name,
        subject="ISO 9283 sheet",
        verdict=" ".join(verdict),
        cards=tuple(cards),
        sections=(*sections, *about),
        counts="; ".join(counted),
        warnings=(*(() if predicted is None else arm_warnings(predicted.arm)), *doubts),
        notes=notes,
        words=_WORDS,
        source=f"{'; '.join(counted)}. The same files, version and seed give the same bytes.",
        seed=None if predicted is None else predicted.seed,
        facts=facts,
    )
    return (
        sheet
        if predicted is None or measured is not None
        else checked(sheet, predicted.check, predicted.check.length, predicted.arm)
    )


def _remarks(found: PredictedRobots) -> list[str]:
    """Return the notes on the prediction."""
    from lostmotion.analyses.iso9283.tables.headline import describes_little_scatter

    out = []
    if found.robots < _FEW:
        out.append(
            f"{several(found.robots, 'robot')}: too few for a 95th percentile, which depends "
            "on the largest one or two"
        )
    if found.still:
        out.append(
            f"joints that do not move in the cycle: {', '.join(found.still)}; their backlash "
            "is assumed to stay on one side"
        )
    sheet = found.loads[0]
    if sheet.repeatability.max() < NO_SCATTER:
        out.append(
            "from one side no described error varies from visit to visit, so no repeatability "
            "is predicted; a real arm adds friction, "
            "control and temperature"
        )
    elif describes_little_scatter(found):
        out.append(
            "RP_l from one side is small because the parts describe little scatter from visit "
            "to visit; a real arm adds friction, control "
            "and temperature. See 'from either side' for the effect of backlash"
        )
    return out


def _facts(found: PredictedRobots) -> dict[str, Any]:
    cube = found.cube
    return {
        "arm": found.arm.name,
        "robots": found.robots,
        "cycles": found.cycles,
        "seed": found.seed,
        "cube": {
            "side_m": cube.side,
            "centre_m": cube.centre.tolist(),
            "tool_rotation": None if cube.rotation is None else cube.rotation.tolist(),
            "poses_m": {name: cube.poses[k, :3, 3].tolist() for k, name in enumerate(NAMES)},
            "q": {name: cube.q[k].tolist() for k, name in enumerate(NAMES)},
            "found_by": cube.method,
        },
        "approach": {name: found.approach[k].tolist() for k, name in enumerate(NAMES)},
    }
