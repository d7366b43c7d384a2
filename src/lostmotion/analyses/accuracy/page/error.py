"""The figures of the error over a study's poses, AP and RP by ISO 9283, and their bands."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.error_model.arrival import ISO_CYCLE, arriving
from lostmotion.error_model.few_poses import weights_of
from lostmotion.error_model.intervals import (
    Estimate,
    of_length,
)
from lostmotion.error_model.share_intervals import share_below
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.propagation.figures import DEVIATION, ROTATION, accuracy, figures_of, repeatability
from lostmotion.propagation.figures import HEADLINE as _HEADLINE
from lostmotion.propagation.montecarlo import kernel
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.sheet import Card, Cell, Row, Section, cell, length, several
from lostmotion.reporting.warnings import few_poses_warnings

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from lostmotion.accuracy.answer import Answer
    from lostmotion.error_model.budget import Budget
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.figures import Figure
    from lostmotion.propagation.figures import Figure as Declared
    from lostmotion.propagation.montecarlo.bands import Bands
    from lostmotion.spatial import Floats

# Key of the share of positions within the target.
WITHIN_TARGET: Final = "within_the_target"
# Of the errors without limits, and of the causes of a band, how many are named.
_MOST_NAMES: Final = 3


def error_section(answer: Answer, where: str = "") -> Section:
    """Return the position error over all poses and at the best and the worst of them; `where`
    follows the number of poses.
    """
    sampled, poses = answer.sampled, answer.poses
    table = sampled.per_pose
    counted = (
        f"{several(len(poses), 'pose')}{where} ({poses.law}) x {several(sampled.robots, 'robot')} "
        f"x {several(sampled.visits, 'visit')}"
    )
    rows = [
        figure_row(
            each, answer.figures[each.key], counted, each.definition if each is DEVIATION else ""
        )
        for each in figures_of(answer.errors).values()
        if each.group == "error" and each is not ROTATION
    ]
    if answer.target is not None:
        within = share_below(
            sampled.group_hist, sampled.replicate_hist, answer.target, sampled.robots
        )
        rows.append(
            Row(
                "within the target",
                (as_share(within, counted),),
                f"target: {length(answer.target, stated=True)}",
                WITHIN_TARGET,
            )
        )
    at = int(table[:, kernel.LARGEST].argmax())
    who = (
        f"robot {table[at, kernel.LARGEST_ROBOT]:.0f}, visit "
        f"{table[at, kernel.LARGEST_VISIT]:.0f}, {described_pose(answer, at)}"
    )
    rows.append(
        Row(
            "largest",
            (length(float(table[at, kernel.LARGEST]), samples=counted),),
            f"of {several(len(poses) * sampled.robots * sampled.visits, 'sample')}: {who}",
        )
    )
    best, worst = int(table[:, kernel.MEAN].argmin()), int(table[:, kernel.MEAN].argmax())
    each = (
        f"{several(sampled.robots, 'robot')} x {several(sampled.visits, 'visit')} at one "
        f"pose{where}"
    )
    for label, k in (("best pose, mean", best), ("worst pose, mean", worst)):
        half = float(table[k, kernel.MEAN_ERROR])
        value = float(table[k, kernel.MEAN])
        rows.append(
            Row(
                label,
                (as_length(of_length(value, value - half, value + half), each),),
                described_pose(answer, k),
            )
        )
        q95 = [float(x) for x in table[k, kernel.FIRST_QUANTILE + 3 : kernel.FIRST_QUANTILE + 6]]
        rows.append(
            Row(label.replace("mean", "95th percentile"), (as_length(Estimate(*q95), each),))
        )
    exact = f"exact sum over terms, {several(len(poses), 'pose')}{where}"
    rows += [
        *limit_rows(answer.arm, float(sampled.rss.max()), float(sampled.worst.max()), exact),
        figure_row(
            ROTATION,
            answer.figures[ROTATION.key],
            exact,
            "exact at the visited poses" if poses.replicates > 1 else "",
        ),
    ]
    note = (
        "best and worst pose are those of the visited poses, chosen by the same samples: their "
        "intervals are valid for a pose chosen beforehand"
    )
    return Section("error", "Position error over the workspace", ("value",), tuple(rows), note)


def limit_rows(arm: Arm, root_sum_square: float, worst: float, counted: str) -> tuple[Row, Row]:
    """Return the rows of the root-sum-square and the worst case, m; where an error has no limits, a
    row that says there is no worst case.
    """
    rss, squares = (
        length(root_sum_square, samples=counted),
        "|bias| + root of the sum of squared limits",
    )
    if math.isfinite(worst):
        bound = "upper bound: sum of the magnitudes of all errors at their limits"
        upper = Row(
            "worst case, worst pose", (length(worst, samples=counted),), bound, "worst_case"
        )
        return Row("root-sum-square, worst pose", (rss,), squares, "root_sum_square"), upper
    endless = [short_name(of.name) for of in arm.terms if math.isinf(of.term.bound)]
    names = ", ".join(endless[:_MOST_NAMES]) + (
        f" and {len(endless) - _MOST_NAMES} more" if len(endless) > _MOST_NAMES else ""
    )
    return (
        Row(
            "root-sum-square, worst pose",
            (rss,),
            f"{squares}; of errors without limits, the stated three standard deviations",
            "root_sum_square",
        ),
        Row(
            "worst case, worst pose",
            (Cell(math.inf, "m", samples=counted, words="none"),),
            f"no worst case: normal without limits ({names})",
            "worst_case",
        ),
    )


def iso_section(answer: Answer, where: str = "") -> Section:
    """Return AP and RP by ISO 9283; `where` follows the number of poses."""
    sampled = answer.sampled
    if sampled.visits < 2:  # noqa: PLR2004 - a scatter needs two
        return Section("iso9283", "ISO 9283, predicted", ("value",), (), "needs at least 2 visits")
    rows = _rows(
        accuracy(sampled.visits), answer, answer.poses, sampled.robots, sampled.accuracy, where
    )
    for each in answer.repeats:
        rows += _rows(
            repeatability(each.approach), answer, each.poses, each.robots, each.per_pose, where
        )
    return Section(
        "iso9283",
        "ISO 9283, predicted",
        ("value",),
        tuple(rows),
        f"pose accuracy AP and repeatability RP by their definitions at n = {sampled.visits}. "
        f"{ISO_CYCLE}: every joint arrives from the same side at "
        "every visit, as in the standard, so makers' figures compare with it; any approach: "
        "from either side at random. "
        f"AP: joints arrive {arriving(answer.approach)}. "
        "A worst pose is the worst visited one, chosen by the same samples: its interval is "
        "valid for a pose chosen beforehand",
    )


def _rows(
    of: tuple[Declared, Declared],
    answer: Answer,
    poses: Poses,
    robots: int,
    per_pose: Floats,
    where: str,
) -> list[Row]:
    """Return mean, 95th percentile of robots and worst pose of AP or RP; per_pose (pose, 4) m."""
    counted = (
        f"{several(robots, 'robot')}, {several(answer.sampled.visits, 'visit')} to each of "
        f"{several(len(poses), 'pose')}{where}"
    )
    at = int(per_pose[:, 1].argmax())
    worst = as_length(Estimate(*(float(x) for x in per_pose[at, 1:])), counted)
    name, key = of[0].name.removesuffix(", mean over poses and robots"), of[0].key
    return [
        figure_row(of[0], answer.figures[of[0].key], counted),
        figure_row(
            of[1], answer.figures[of[1].key], counted, "each robot's average over the poses"
        ),
        Row(
            f"{name}, at its worst pose, 95th percentile of robots",
            (worst,),
            f"pose {at}: {joint_values(answer.arm, poses.q[at])}",
            f"{key.removesuffix('_mean')}_worst_pose_p95",
        ),
    ]


def few_poses(blame: Budget, visits: int, approach: float) -> tuple[str, ...]:
    """Return the sentence that the poses are too few for position error, AP or RP; nothing where
    they are enough, or not checked.
    """
    if not len(blame.squares.many):
        return ()
    return few_poses_warnings(
        blame.poses,
        {
            name: blame.squares.root_mean_squares(weights)
            for name, weights in weights_of(visits, approach).items()
        },
    )


def described_pose(answer: Answer, index: int) -> str:
    """Name a pose by its number and joint values."""
    return f"pose {index}: {joint_values(answer.arm, answer.poses.q[index])}"


def figure_row(of: Declared, estimate: Estimate, counted: str, note: str = "") -> Row:
    """Return the row of a declared figure."""
    return Row(of.name, (cell(estimate, of.unit, counted),), note, of.key)


def as_length(estimate: Estimate, samples: str) -> Cell:
    """Return an estimate (m) in the unit that suits its size."""
    return length(estimate.value, estimate.low, estimate.high, samples)


def as_share(estimate: Estimate, samples: str) -> Cell:
    """Return the estimate of a share, 0..1, in per cent."""
    return Cell(estimate.value, "%", estimate.low, estimate.high, samples)


COLUMNS: Final = ("5th percentile", "middle", "95th percentile")
# Share of a range in the variance of a figure from which it is named with the figure.
_NAMED: Final = 0.2


def bands_sections(
    bands: Bands | None, declared: Iterable[Figure], figures: Mapping[str, Estimate]
) -> tuple[Section, ...]:
    """Return the table of the bands, and that of the ranges behind them; none where every value is
    known.
    """
    if bands is None:
        return ()
    drawn = f"{several(len(bands.shares), 'draw')} of {several(len(bands.unknown), 'range')}"
    rows = []
    for each in declared:
        value = _value(bands, each.key, figures)
        if value:
            low, high = bands.band(each.key, value)
            cells = (length(end, samples=drawn) for end in (low, value, high))
            rows.append(Row(each.name, tuple(cells), key=each.key))
    note = (
        f"over {drawn}: a value known only as a range is the same for all robots. Every draw "
        f"has the same {several(bands.robots, 'robot')}, "
        f"{several(bands.visits, 'visit')} and {several(bands.poses, 'pose')}, and is taken "
        "relative to the middle of each range. A band contains "
        "no confidence interval"
    )
    ranges = [
        Row(key, (Cell(share, "%", samples=drawn),))
        for key, share in bands.influence(_HEADLINE).items()
    ]
    of_ranges = (
        "share of the variance of the 95th percentile that each range explains by itself; the "
        "largest is the first to measure"
    )
    return (
        Section("bands", "What the ranges leave open", COLUMNS, tuple(rows), note),
        Section("ranges", "Ranges", ("share of variance",), tuple(ranges), of_ranges),
    )


def bands_clause(bands: Bands | None, figures: Mapping[str, Estimate]) -> str:
    """Return the clause of the headline on how far the 95 % error depends on ranges; empty where it
    does not.
    """
    value = 0.0 if bands is None else _value(bands, _HEADLINE, figures)
    if bands is None or not value:
        return ""
    causes = [key for key, share in bands.influence(_HEADLINE).items() if share > _NAMED][
        :_MOST_NAMES
    ]
    mostly = f" (first of all {', '.join(causes)})" if causes else ""
    return (
        f"values known only as ranges{mostly} leave {_text(bands, _HEADLINE, value)} open "
        "(5 to 95 %)"
    )


def with_band(card: Card, bands: Bands | None, figures: Mapping[str, Estimate]) -> Card:
    """Return the card of a figure with its band beside the interval."""
    value = 0.0 if bands is None else _value(bands, card.key, figures)
    if bands is None or not value:
        return card
    quiet = f"{card.quiet}; ranges {_text(bands, card.key, value)}" if card.quiet else ""
    return replace(card, quiet=quiet)


def bands_facts(bands: Bands | None) -> dict[str, Any]:
    """Return what result.json holds of the ranges besides the figures: their limits in SI; nothing
    where every value is known.
    """
    if bands is None:
        return {}
    return {
        "ranges": [
            {"key": each.name, "low": each.band.low, "high": each.band.high, "law": each.band.law}
            for each in bands.unknown
        ]
    }


def _text(bands: Bands, key: str, value: float) -> str:
    low, high = (length(end) for end in bands.band(key, value))
    return f"{low} .. {high}"


def _value(bands: Bands, key: str, figures: Mapping[str, Estimate]) -> float:
    """Return a figure that has a band, m; zero for others."""
    value = figures[key].value if key in bands.ratios and key in figures else 0.0
    return value if math.isfinite(value) else 0.0
