"""Sheet of a calibration: accuracy before and after, families of errors, estimates, parts
out of tolerance, and rows that were weighted down.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.calibrate.answer import (
    FEWEST_COUNTED,
    PARTLY,
    UNRESOLVED,
    size,
)
from lostmotion.analyses.calibrate.page.remaining import (
    next_measurements,
    predicted_accuracy,
    refusals,
)
from lostmotion.calibration.terms import is_frame
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.sheet import Card, Cell, Row, Sheet, in_words, length, several, table

if TYPE_CHECKING:
    from lostmotion.analyses.calibrate.answer import CalibrationAnswer
    from lostmotion.calibration.robot import EstimatedError
    from lostmotion.reporting.sheet import Section
    from lostmotion.spatial import Floats

_SHOWN: Final = 60
_WORST: Final = 10
_PERIODIC: Final = 12
_QUANTILE: Final = 0.95
_WORDS: Final = (
    (
        "held out",
        (
            "measurements that the estimates did not use: the poses are split in five, and each "
            "fifth is predicted from the others. Random folds are for poses among the measured "
            "ones, excluded regions for poses beside them."
        ),
    ),
    (
        "resolved",
        (
            "share of the prior variance of an error that the measurement removed. Below 10 % "
            "these poses do not resolve it, below 75 % partly: it is then tied to another error."
        ),
    ),
    (
        "prior",
        (
            "standard deviation by the tolerance in the arm file, or assumed for an error that it "
            "does not state: normal, or Student's t with `--prior student-t`."
        ),
    ),
    (
        "released",
        (
            "error whose prior was widened because the log evidence rises by more than 5 nats: the "
            "part is out of its tolerance, or the tolerance is too narrow. With Student-t priors: "
            "whose prior became at least 4 times as wide."
        ),
    ),
    ("log evidence", "logarithm of the probability density of the measurement, nats."),
)
_DRIFTED: Final = (
    "drift: from the first row to the last; all else is of the middle of the measurement"
)


def calibrated_sheet(answer: CalibrationAnswer) -> Sheet:
    """Return the sheet of a calibration."""
    robot = answer.robot
    counted = answer.counts
    return Sheet(
        name=robot.arm.name,
        subject="calibration of one robot",
        verdict=_verdict(answer),
        cards=_cards(answer),
        sections=(
            _accuracy(answer),
            _families(answer, counted),
            *_repeats(answer),
            *_released(answer),
            _estimates(answer),
            *_periodic(answer),
            *_frames(answer),
            predicted_accuracy(answer),
            *refusals(answer),
            next_measurements(answer),
            _rows(answer),
        ),
        counts=f"{counted}, seed {answer.seed}",
        warnings=answer.warnings,
        notes=(*answer.remaining, *robot.arm.notes),
        words=_WORDS,
        source=f"{counted}, seed {answer.seed}, data {answer.visits.digest}. The same files, "
        "version and seed give the same bytes.",
        seed=answer.seed,
        facts={
            "arm": robot.arm.name,
            "findings": list(answer.findings),
            "data": {
                "poses": len(answer.visits),
                "visits": answer.taken,
                "hash": answer.visits.digest,
            },
            "noise_m": robot.noise(robot.climb.kept.fit),
            "inflation": robot.inflation,
            "variance_elsewhere": answer.elsewhere,
        },
    )


def _verdict(answer: CalibrationAnswer) -> str:
    first, held, _ = answer.errors_held_out
    sizes = (first.mean(), held.mean(), np.quantile(held, _QUANTILE))
    before, after, most = (length(float(each)) for each in sizes)
    text = (
        f"Before {before}, after {after} at poses that were not measured (95 % {most}), each with "
        "the best base and tool frame."
    )
    return " ".join([text, *(f"{each[0].upper()}{each[1:]}." for each in answer.findings)])


def _cards(answer: CalibrationAnswer) -> tuple[Card, ...]:
    climb = answer.robot.climb
    before, after, blocked = (str(length(float(each.mean()))) for each in answer.errors_held_out)
    cards = [
        Card("before", before, "base and tool frame alone"),
        Card("after", after, "mean error, held out"),
        Card("excluded regions", blocked, "mean error, held out"),
        Card("noise", str(length(answer.robot.noise(climb.kept.fit))), "of a coordinate"),
    ]
    released = len(climb.kept.fit.released)
    if released:
        cards.append(Card("out of tolerance", str(released), several(released, "error")))
    return tuple(cards)


def _accuracy(answer: CalibrationAnswer) -> Section:
    climb, used = answer.robot.climb, answer.counted
    counted = several(int(used.sum()), "pose")
    before, random, blocked = answer.errors_held_out

    def row(label: str, error: Floats, note: str, key: str) -> Row:
        mean = float(error.mean())
        wide = 1.96 * float(error.std(ddof=1)) / np.sqrt(len(error))
        cells = (
            length(mean, max(mean - wide, 0.0), mean + wide, counted),
            length(float(np.quantile(error, _QUANTILE)), samples=counted),
            length(float(error.max()), samples=counted),
        )
        return Row(label, cells, note, key)

    note = (
        f"{100 * climb.kept.blocked.coverage:.0f} % of the measurements in excluded regions are "
        "within their 95 % regions, whose covariances the other regions inflate; those of the "
        f"result are multiplied by {answer.robot.inflation:.3g}"
    )
    if len(answer.visits) < FEWEST_COUNTED:
        note += f"; coverage is not judged from fewer than {FEWEST_COUNTED} poses"
    aside = answer.robot.aside
    if aside is not None:
        share = 100 * aside.within(answer.robot.inflation).mean()
        note += f"; of the {several(len(aside.error), 'row')} kept aside {share:.0f} %"
    return table(
        "accuracy",
        "Accuracy before and after",
        ("mean", "95th percentile", "largest"),
        [
            row("as measured", answer.raw[used], "nominal arm, base as measured", "raw"),
            row("base and tool frame", before, "held out, random folds", "before"),
            row("calibrated, random folds", random, "held out", "random"),
            row("calibrated, excluded regions", blocked, "held out", "blocked"),
            *([] if aside is None else [row("kept aside", aside.error, "not used", "aside")]),
            row("fitted poses", answer.fitted[used], "residual; no accuracy", "fitted"),
        ],
        note,
    )


def _families(answer: CalibrationAnswer, counted: str) -> Section:
    rows = [
        (
            rung.name,
            rung.count,
            length(rung.blocked.mean, samples=counted),
            length(answer.robot.noise(rung.fit), samples=counted),
            Cell(rung.fit.evidence, "1", samples=counted),
            (f"up to order {rung.fit.orders}" if rung.fit.orders else "")
            if rung.kept
            else f"not estimated: {rung.reason}",
        )
        for rung in answer.robot.climb.rungs
    ]
    return table(
        "families",
        "Families of errors",
        ("errors", "mean error, excluded regions", "noise", "log evidence"),
        rows,
        "each family includes those above it",
    )


def _repeats(answer: CalibrationAnswer) -> list[Section]:
    """Return the scatter of repeated measurements; nothing without any."""
    of = answer.repeats
    if of is None:
        return []
    counted = f"{of.rows} rows at {several(of.poses, 'pose')}"
    measured = length(of.deviation, of.low, of.high, counted)
    left = length(answer.robot.climb.kept.fit.noise)
    note = "the estimates use the mean of the visits to a pose. Beside the scatter of its visits "
    note += f"each coordinate of a mean is {left} off, by what the model lacks"
    rows = [
        ("measured: same pose, approach and payload", measured, counted),
        ("predicted from the arm file", length(answer.robot.repeated.predicted), "robot alone"),
    ]
    return [table("repeats", "Repeated measurements", ("standard deviation",), rows, note)]


def _released(answer: CalibrationAnswer) -> list[Section]:
    released = answer.robot.climb.kept.fit.released
    if not released:
        return []
    of = {error.draw: error for error in answer.robot.errors}
    rows = [
        (
            short_name(error.name),
            size(error, error.value),
            size(error, 2 * error.deviation),
            size(error, error.prior),
            Cell(each.factor, "1", stated=True),
            Cell(each.gain, "1"),
            "" if error.in_file else "not in the arm file",
        )
        for each in released
        for error in [of[each.draw]]
    ]
    return [
        table(
            "released",
            "Errors out of tolerance",
            ("estimate", "± 95 %", "prior", "widened", "gain of log evidence"),
            rows,
        )
    ]


def _estimates(answer: CalibrationAnswer) -> Section:
    shown = [each for each in answer.robot.errors if not each.periodic][:_SHOWN]
    return table(
        "estimates",
        "Estimated errors, largest effect first",
        ("estimate", "± 95 %", "prior", "resolved", "effect at the tool"),
        [_estimate(each) for each in shown],
        "effect: r.m.s. motion of the tool point by the estimate at the measured poses"
        + (f"; {_DRIFTED}" if any(each.name.startswith("drift") for each in shown) else ""),
    )


def _estimate(error: EstimatedError) -> tuple[Any, ...]:
    notes = [] if error.in_file else ["frame" if error.frame else "not in the arm file"]
    tied = f"tied to {short_name(error.tied)} ({error.correlation:+.2f})"
    if error.resolved < UNRESOLVED:
        value: Cell = in_words("not resolved")
        notes.append(f"by these poses; {tied}")
    else:
        value = size(error, error.value)
        if error.resolved < PARTLY:
            notes.append(f"partly resolved; {tied}")
    return (
        short_name(error.name),
        value,
        size(error, 2 * error.deviation),
        size(error, error.prior),
        Cell(error.resolved, "%"),
        length(error.effect),
        "; ".join(notes),
    )


def _periodic(answer: CalibrationAnswer) -> list[Section]:
    """Return the largest periodic errors, both phases together."""
    of: dict[tuple[str, str], list[EstimatedError]] = {}
    for error in answer.robot.errors:
        if error.periodic:
            owner, _, name = error.name.rpartition(".")
            of.setdefault((owner, name.rpartition(" ")[2]), []).append(error)
    if not of:
        return []
    amplitude = {key: float(np.linalg.norm([e.value for e in pair])) for key, pair in of.items()}
    largest = sorted(amplitude, key=lambda key: -amplitude[key])[:_PERIODIC]
    rows = [
        (
            f"{short_name(owner)} order {order}",
            Cell(amplitude[owner, order], "arcsec"),
            Cell(2 * of[owner, order][0].deviation, "arcsec"),
            length(float(np.linalg.norm([each.effect for each in of[owner, order]]))),
        )
        for owner, order in largest
    ]
    return [
        table(
            "periodic",
            "Largest periodic errors of the joints",
            ("amplitude", "± 95 %", "effect at the tool"),
            rows,
            "cycles per turn of the joint; their cause is not known",
        )
    ]


def _frames(answer: CalibrationAnswer) -> list[Section]:
    """Return the base and tool frame to which every other command compares this robot."""
    own, measured = answer.robot.calibrations
    names = [name for name, _ in own.streams]
    rows = [
        (of.name, Cell(turn, "mrad") if turning else length(turn))
        for of in own.added
        if is_frame(of.owner)
        for k in [names.index(of.name)]
        for turn in [of.term.scale * float(measured.mean[k] - own.mean[k])]
        for turning in [of.term.name.startswith("turn")]
    ]
    note = "with them the nominal arm is nearest to this robot; with robot.toml every command "
    note += "compares it with these frames, which count as no error"
    title = "Base and tool frame that fit this robot best"
    return [table("frames", title, ("from the arm file",), rows, note)] if rows else []


def _rows(answer: CalibrationAnswer) -> Section:
    climb = answer.robot.climb
    order = np.argsort(-climb.random.error, kind="stable")[:_WORST]
    rows = [
        (
            f"line {answer.visits.lines[k]}",
            length(float(climb.random.error[k])),
            length(float(answer.fitted[k])),
            Cell(float(climb.kept.fit.weights[k]), "1"),
            joint_values(answer.robot.arm, answer.visits.q[k]),
        )
        for k in order
    ]
    return table("rows", "Rows with the largest error", ("held out", "fitted", "weight"), rows)
