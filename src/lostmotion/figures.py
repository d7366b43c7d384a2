"""The figures of a study as a person reads them: label, value, unit, interval, sample. Screen, report and result.json all print these."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lostmotion.studies import kernel
from lostmotion.studies.budget import costs
from lostmotion.studies.intervals import Estimate, pooled_mean, pooled_quantile, pooled_robots_quantile

if TYPE_CHECKING:
    from lostmotion.spatial import Floats
    from lostmotion.studies.answer import Answer

ARCMIN = math.pi / 10800
# In the units people read (µm, mm, N m, %) anything smaller is what rounding leaves of zero.
_NOTHING = 1e-7


@dataclass(frozen=True, slots=True)
class Figure:
    """One number: value and ends of its 95 % interval in `unit` (NaN where there is none), and what it was counted from."""

    value: float
    unit: str
    low: float = math.nan
    high: float = math.nan
    samples: str = ""
    ends: str = "95 % interval"

    def __str__(self) -> str:
        """Say the value with its unit, to the digits that its interval or its size deserves."""
        if self.unit == "%":
            return f"{'<0.01' if 0 < abs(self.value) < 0.005 else f'{self.value:.2f}'} %"  # noqa: PLR2004 - would show as 0.00
        close = self.high - self.low
        return f"{digits(self.value, close if math.isfinite(close) else 0.0)} {self.unit}".strip()

    @property
    def interval(self) -> str:
        """Say the interval, or nothing where there is none."""
        if math.isnan(self.low) and math.isnan(self.high):
            return ""
        spans = (self.high - self.low, self.high - self.value, self.value - self.low)
        close = next((abs(span) for span in spans if math.isfinite(span)), 0.0)
        ends = ("?" if not math.isfinite(end) else digits(end, close) for end in (self.low, self.high))
        return " … ".join(ends) + ("" if self.ends == "95 % interval" else f" ({self.ends})")


@dataclass(frozen=True, slots=True)
class Row:
    """A line of a section: what it is, its figures, and a remark."""

    label: str
    figures: tuple[Figure, ...]
    note: str = ""


@dataclass(frozen=True, slots=True)
class Section:
    """A titled block of figures; `columns` names the figures of its rows."""

    key: str
    title: str
    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    note: str = ""


def digits(value: float, uncertainty: float = 0.0) -> str:
    """Write a number with four digits, or as many as the width of its interval (two digits of it) leaves meaning."""
    if not math.isfinite(value):
        return "not known" if math.isnan(value) else "unbounded"
    if abs(value) < _NOTHING:
        return "0"
    places = 3 - math.floor(math.log10(abs(value)))
    if uncertainty > 0:
        places = 1 - math.floor(math.log10(uncertainty))
    places = max(places, 0)
    return f"{value:.{min(places, 9)}f}"


def length(value: float, low: float = math.nan, high: float = math.nan, samples: str = "") -> Figure:
    """Give a length (m) in the unit that suits its size: µm, mm or m."""
    unit, factor = ("µm", 1e6) if abs(value) < 1e-4 else ("mm", 1e3) if abs(value) < 1 else ("m", 1.0)  # noqa: PLR2004 - where people change units
    return Figure(value * factor, unit, low * factor, high * factor, samples)


def _of(estimate: Estimate, samples: str) -> Figure:
    return length(estimate.value, estimate.low, estimate.high, samples)


def sections(answer: Answer) -> list[Section]:
    """Which figures answer the user's questions? In reading order."""
    return [_workspace(answer), _error(answer), _iso(answer), _levels(answer), _budget(answer), _torques(answer), _check(answer)]


def described_pose(answer: Answer, index: int) -> str:
    """Name a pose by its number and joint values."""
    return f"pose {index}: {joint_values(answer, answer.poses.q[index])}"


def joint_values(answer: Answer, q: Floats) -> str:
    """Write joint values in degrees and millimetres."""
    parts = []
    for joint, value in zip(answer.arm.moving, q, strict=True):
        parts.append(f"{joint.name} {math.degrees(value):.1f}°" if joint.type == "revolute" else f"{joint.name} {value * 1e3:.1f} mm")
    return ", ".join(parts)


def _workspace(answer: Answer) -> Section:
    space = answer.workspace
    counted = f"{len(space.points)} poses, {space.law}"
    rows = [
        Row("reach from the base", (length(space.reach, samples=counted),), "largest of the sample; the true reach is not smaller"),
        Row("reach seen from above", (length(space.reach_horizontal, samples=counted),)),
        Row("nearest to the base", (length(space.nearest, samples=counted),), "smallest of the sample"),
    ]
    for k, name in enumerate("XYZ"):
        rows.append(Row(f"least {name}", (length(float(space.low[k]), samples=counted),)))
        rows.append(Row(f"largest {name}", (length(float(space.high[k]), samples=counted),)))
    if space.volume_high > 0:
        volume = Figure(space.volume, "m³", space.volume_low, space.volume_high, counted, "bracket")
        rows.append(Row("volume", (volume,), f"between the cells well inside and all cells visited; cell {space.cell * 1e3:.0f} mm"))
    else:
        rows.append(Row("volume", (Figure(0.0, "m³", samples=counted),), "the workspace is a line or a surface"))
    return Section("workspace", "Workspace", ("value",), tuple(rows), "joint limits only: no obstacle, floor or self-collision")


def _error(answer: Answer) -> Section:
    sampled, poses = answer.sampled, answer.poses
    table = sampled.per_pose
    counted = f"{len(poses)} poses ({poses.law}) x {sampled.robots} robots x {sampled.visits} visits"
    mean = pooled_mean(sampled.robot_means[:, :, 0])
    largest = float(table[:, kernel.LARGEST].max())
    quantiles = {level: pooled_quantile(sampled.group_hist, sampled.replicate_hist, level, largest) for level in kernel.QUANTILES}
    rows = [Row("mean", (_of(mean, counted),)), *(Row(f"{100 * level:.0f} % below", (_of(found, counted),)) for level, found in quantiles.items())]
    at = int(table[:, kernel.LARGEST].argmax())
    who = f"robot {table[at, kernel.LARGEST_ROBOT]:.0f}, visit {table[at, kernel.LARGEST_VISIT]:.0f}, {described_pose(answer, at)}"
    rows.append(
        Row(
            "largest",
            (length(float(table[at, kernel.LARGEST]), samples=counted),),
            f"of {len(poses) * sampled.robots * sampled.visits} samples: {who}",
        )
    )
    best, worst = int(table[:, kernel.MEAN].argmin()), int(table[:, kernel.MEAN].argmax())
    each = f"{sampled.robots} robots x {sampled.visits} visits at one pose"
    for label, k in (("best pose, mean", best), ("worst pose, mean", worst)):
        half = float(table[k, kernel.MEAN_ERROR])
        value = float(table[k, kernel.MEAN])
        rows.append(Row(label, (length(value, value - half, value + half, each),), described_pose(answer, k)))
        q95 = [float(x) for x in table[k, kernel.FIRST_QUANTILE + 3 : kernel.FIRST_QUANTILE + 6]]
        rows.append(Row(label.replace("mean", "95 % below"), (_of(Estimate(*q95), each),)))
    exact = f"exact sum over terms, {len(poses)} poses"
    rows += [
        Row("root-sum-square, worst pose", (length(float(sampled.rss.max()), samples=exact),), "|bias| + root of the sum of squared limits"),
        Row(
            "worst case, worst pose",
            (length(float(sampled.worst.max()), samples=exact),),
            "upper bound: the sizes of all errors at their limits, added",
        ),
        Row("rotation of the tool, r.m.s.", (Figure(float(np.sqrt(sampled.rotation_ms.mean())) / ARCMIN, "arcmin", samples=exact),)),
    ]
    note = "best and worst pose are chosen by the same samples: their intervals hold for a pose named beforehand"
    return Section("error", "Position error over the workspace", ("value",), tuple(rows), note)


def _iso(answer: Answer) -> Section:
    sampled = answer.sampled
    if sampled.visits < 2:  # noqa: PLR2004 - a scatter needs two
        return Section("iso9283", "ISO 9283, predicted", ("value",), (), "needs at least 2 visits")
    counted = f"{sampled.robots} robots, {sampled.visits} visits to each of {len(answer.poses)} poses"
    rows = []
    for label, column, table in (("AP", 1, sampled.accuracy), ("RP", 2, sampled.repeatability)):
        of_robots = sampled.robot_means[:, :, column]
        rows.append(Row(f"{label}, mean over poses and robots", (_of(pooled_mean(of_robots), counted),)))
        rows.append(Row(f"{label}, 95 % of robots below", (_of(pooled_robots_quantile(of_robots), counted),), "each robot's average over the poses"))
        at = int(table[:, 1].argmax())
        rows.append(
            Row(
                f"{label} at its worst pose, 95 % of robots below",
                (_of(Estimate(*(float(x) for x in table[at, 1:])), counted),),
                described_pose(answer, at),
            )
        )
    arriving = (
        "each joint arrives from either side at random"
        if answer.approach == 0
        else f"every joint arrives moving {'up' if answer.approach > 0 else 'down'}"
    )
    return Section(
        "iso9283",
        "ISO 9283, predicted",
        ("value",),
        tuple(rows),
        f"pose accuracy AP and repeatability RP by their definitions at n = {sampled.visits}; {arriving}",
    )


def _levels(answer: Answer) -> Section:
    tally = answer.sampled.tally
    counted = f"exact sum over terms, {tally.poses} poses"
    names = (
        ("from load and pose", "a controller that knows the load can take it away"),
        ("from how each robot was built", "calibration can take it away"),
        ("from visit to visit", "nothing takes it away"),
    )
    rows = [
        Row(
            label,
            (
                length(math.sqrt(level / tally.poses), samples=counted),
                Figure(100 * level / tally.total if tally.total else 0.0, "%", samples=counted),
            ),
            note,
        )
        for (label, note), level in zip(names, tally.levels, strict=True)
    ]
    rows.append(Row("all together", (length(math.sqrt(tally.total / tally.poses), samples=counted), Figure(100.0, "%", samples=counted))))
    left = tally.total - float(tally.levels[0])
    share = Figure(100 * left / tally.total if tally.total else 0.0, "%", samples=counted)
    rows.append(Row("left when load and pose are compensated", (length(math.sqrt(max(left, 0.0) / tally.poses), samples=counted), share)))
    return Section("levels", "What can be done about it", ("r.m.s. error", "share of mean square"), tuple(rows))


def _budget(answer: Answer) -> Section:
    halving = answer.halving
    exact = f"exact sum over terms, {len(answer.poses)} poses"
    counted = f"{halving.samples} paired samples"
    rows = []
    for cost in costs(answer.sampled.tally):
        gain = halving.gains[cost.part]
        scale = 1e6
        rows.append(
            Row(
                cost.part.removeprefix("joints."),
                (
                    Figure(cost.alone * 1e6, "µm", samples=exact),
                    Figure(100 * cost.share, "%", samples=exact),
                    Figure(gain.value * scale, "µm", gain.low * scale, gain.high * scale, counted),
                ),
                "cancels part of the others" if cost.share < -5e-4 else "",  # noqa: PLR2004 - shows as -0.1 % or more
            ),
        )
    read_on = f"{digits(halving.before * 1e3)} mm on the {halving.samples} samples used for it"
    note = (
        "r.m.s. alone: all other parts ideal. Shares of the mean square add to 100 %. Halving: by how much the 95 % error falls when "
        f"this part errs half as much, its interval counting robots; read on {read_on}"
    )
    return Section("budget", "Which part is to blame", ("r.m.s. alone", "share", "halving it takes off the 95 %"), tuple(rows), note)


def _torques(answer: Answer) -> Section:
    counted = f"{len(answer.poses)} poses"
    rows = tuple(
        Row(
            held.joint,
            (Figure(held.worst, held.unit, samples=counted), Figure(held.over_tilts, held.unit, samples=counted)),
            f"{described_pose(answer, held.worst_index)}; over tilts pose {held.over_tilts_index}",
        )
        for held in answer.worst_torques
    )
    return Section(
        "torques",
        "Static torque that each drive must hold",
        ("as the base stands", "worst over base tilts"),
        rows,
        "largest of the poses visited; its sign is the drive's",
    )


def _check(answer: Answer) -> Section:
    exact = answer.sampled.exact
    q95 = pooled_quantile(answer.sampled.group_hist, answer.sampled.replicate_hist, 0.95).value
    counted = f"{exact.samples} samples"
    share = 100 * exact.largest / q95 if q95 else 0.0
    warn = "more than 1 %: the first-order figures are that uncertain" if share > 1 else "first order is enough"
    rows = (
        Row("largest difference", (length(exact.largest, samples=counted),)),
        Row("mean difference", (length(exact.mean, samples=counted),)),
        Row("largest, of the 95 % error", (Figure(share, "%", samples=counted),), warn),
    )
    return Section("exact_check", "First order against exact composition", ("value",), rows)


def result(answer: Answer, version: str) -> dict[str, Any]:
    """Give every printed figure as plain data for result.json: no clock time, so that two runs can be compared byte by byte."""
    sampled = answer.sampled
    return {
        "lostmotion": version,
        "arm": answer.arm.name,
        "seed": answer.seed,
        "poses": {"count": len(answer.poses), "law": answer.poses.law, "independent_sets": answer.poses.replicates},
        "robots": sampled.robots,
        "visits": sampled.visits,
        "intervals": "95 %, counting robots and sets of poses; at a single pose and for halving, counting robots",
        "notes": list(answer.arm.notes),
        "sections": [
            {
                "key": section.key,
                "title": section.title,
                "note": section.note,
                "rows": [
                    {
                        "label": row.label,
                        "note": row.note,
                        "figures": [_plain(name, figure, answer.seed) for name, figure in zip(section.columns, row.figures, strict=True)],
                    }
                    for row in section.rows
                ],
            }
            for section in sections(answer)
        ],
    }


def _plain(name: str, figure: Figure, seed: int) -> dict[str, Any]:
    ends = [end if math.isfinite(end) else None for end in (figure.low, figure.high)]
    return {
        "name": name,
        "value": figure.value if math.isfinite(figure.value) else None,
        "unit": figure.unit,
        "interval": None if ends == [None, None] else ends,
        "interval_kind": None if ends == [None, None] else figure.ends,
        "samples": figure.samples,
        "seed": seed,
    }
