"""The figures of a study: workspace, position error, ISO 9283, budget, torques, and what they say in a sentence."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.figures import ARCMIN, Card, Figure, Row, Section, Sheet, find_row, length
from lostmotion.figures.budget import asked_sections, budget_section, by_level_sections, causes_section, levels_section
from lostmotion.figures.stopping import stopping_section, told
from lostmotion.figures.waterfall import waterfall_section
from lostmotion.studies.intervals import Estimate, pooled_mean, pooled_quantile, pooled_robots_quantile
from lostmotion.studies.montecarlo import kernel
from lostmotion.studies.statics.causes import NEXT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats
    from lostmotion.studies.answer import Answer
    from lostmotion.studies.montecarlo.stopping import Stopping

# What the words mean, for whoever reads the report without the manual.
_WORDS: Final = (
    ("position error", "distance between the point the tool was sent to and the point it reaches."),
    (
        "design, robot, visit",
        "where an error comes from: load and pose, alike in every arm of this design; how one robot was built; one visit of a pose to the next.",
    ),
    ("AP", "pose accuracy of ISO 9283: how far the average of a robot's visits lies from the commanded point. Predicted here, not certified."),
    ("RP", "pose repeatability of ISO 9283: how far its visits scatter about their own average, mean plus three standard deviations."),
    ("interval", "95 % confidence. It counts robots and independent sets of poses, never single samples. A question mark: too few of them to tell."),
    ("share", "of the mean-square error. Shares add to 100 %; a negative one cancels part of the others, so that the arm would be worse without it."),
    ("first order", "errors are small and are added up. Composing a sample of them exactly shows what that leaves out."),
)


def sheet(answer: Answer) -> Sheet:
    """What is there to say about a study? All of it, in reading order."""
    found = tuple(sections(answer))
    sampled, poses = answer.sampled, answer.poses
    return Sheet(
        name=answer.arm.name,
        subject="predicted accuracy",
        counts=f"{sampled.robots} robots x {sampled.visits} visits x {len(poses)} poses, seed {answer.seed}",
        verdict=_verdict(found, answer.stopping),
        cards=tuple(_cards(found)),
        sections=found,
        notes=answer.arm.remarks,
        words=_WORDS,
        source=_source(answer),
        arrays="what was found for every pose and robot",
        seed=answer.seed,
        facts={
            "arm": answer.arm.name,
            "seed": answer.seed,
            "poses": {"count": len(poses), "law": poses.law, "independent_sets": poses.replicates},
            "robots": sampled.robots,
            "visits": sampled.visits,
            "intervals": "95 %, counting robots and sets of poses; at a single pose, counting robots",
        },
    )


def sections(answer: Answer) -> list[Section]:
    """Which figures answer the user's questions? In reading order."""
    found = [
        _workspace(answer),
        _error(answer),
        _iso(answer),
        levels_section(answer),
        waterfall_section(answer.waterfall, _repeats(answer)),
        budget_section(answer),
        causes_section(answer),
        *by_level_sections(answer.budget),
        *asked_sections(answer.budgets),
        *_bending(answer),
        _torques(answer),
        _check(answer),
    ]
    if answer.stopping is not None:
        found.append(stopping_section(answer.stopping))
    if answer.analytic is not None and answer.pooled is not None:
        from lostmotion.figures.analytic import analytic_section, comparison

        found += [analytic_section(answer.poses, answer.analytic, answer.pooled), comparison(answer.analytic, answer.sampled)]
    return found


def _repeats(answer: Answer) -> Estimate | None:
    return pooled_mean(answer.sampled.robot_means[:, :, 2]) if answer.sampled.visits > 1 else None


def described_pose(answer: Answer, index: int) -> str:
    """Name a pose by its number and joint values."""
    return f"pose {index}: {joint_values(answer, answer.poses.q[index])}"


def joint_values(answer: Answer, q: Floats) -> str:
    """Write joint values in degrees and millimetres."""
    parts = []
    for joint, value in zip(answer.arm.moving, q, strict=True):
        parts.append(f"{joint.name} {math.degrees(value):.1f}°" if joint.type == "revolute" else f"{joint.name} {value * 1e3:.1f} mm")
    return ", ".join(parts)


def _of(estimate: Estimate, samples: str) -> Figure:
    return length(estimate.value, estimate.low, estimate.high, samples)


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


def _bending(answer: Answer) -> list[Section]:
    """Lay out how links bend, the whole and below it by cause; no section for links that are rigid."""
    if not answer.bending:
        return []
    counted, exact = f"the worst of {len(answer.poses)} poses", f"exact sum over {len(answer.poses)} poses"
    rows = []
    for bent in answer.bending:
        shares = sum(share for _, _, share in bent.by_cause.values())
        within = f", l/{bent.length / bent.deflection:.0f}" if bent.deflection else ""
        at = f"pose {bent.deflection_index}{within}" + (f"; slope at pose {bent.slope_index}" if bent.slope_index != bent.deflection_index else "")
        lines = [(bent.joint, (bent.deflection, bent.slope, shares), at)]
        lines += [(f"{bent.joint}, {NEXT.get(cause, cause)}", parts, "") for cause, parts in bent.by_cause.items() if any(parts)]
        rows += [
            Row(
                label,
                (
                    Figure(deflection * 1e6, "µm", samples=counted),
                    Figure(slope / ARCMIN, "arcmin", samples=counted),
                    Figure(100 * share, "%", samples=exact),
                ),
                note,
            )
            for label, (deflection, slope, share), note in lines
        ]
    note = (
        "each link that gives, named after its joint, from there to its tip, l away; then each cause's part along the whole, so that parts add up; "
        "a minus sign: that weight bends it back. Share: of the tool's mean-square error over all poses"
    )
    return [Section("bending", "Bending by cause", ("deflection", "slope", "share"), tuple(rows), note)]


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


def _verdict(found: Sequence[Section], stopping: Stopping | None) -> str:
    """Say in a sentence or three what the user asked: how far off, which part is dearest, how well it repeats."""
    error = find_row(found, "error", "95 % below")
    said = []
    if error is not None:
        figure = error.figures[0]
        said.append(f"Expect 95 % of positions within {figure}{f' ({figure.interval})' if figure.interval else ''}.")
    parts = next((section.rows for section in found if section.key == "budget"), ())
    if parts and parts[0].figures[1].value > 0:
        said.append(f"The dearest part is {parts[0].label} with {parts[0].figures[1]} of the mean-square error.")
    repeats = find_row(found, "iso9283", "RP, 95 % of robots below")
    if repeats is not None:
        said.append(f"95 % of the robots built repeat within {repeats.figures[0]}.")
    if stopping is not None:
        said.append(told(stopping) + ".")
    return " ".join(said)


def _cards(found: Sequence[Section]) -> list[Card]:
    """Show the six figures that are asked for first, each with its interval."""
    wanted = (
        ("95 % of positions within", "error", "95 % below"),
        ("mean position error", "error", "mean"),
        ("accuracy AP, 95 % of robots within", "iso9283", "AP, 95 % of robots below"),
        ("repeatability RP, 95 % of robots within", "iso9283", "RP, 95 % of robots below"),
        ("reach from the base", "workspace", "reach from the base"),
    )
    rows = [(title, find_row(found, section, label)) for title, section, label in wanted]
    cards = [
        Card(title, str(row.figures[0]), f"interval {row.figures[0].interval}" if row.figures[0].interval else row.note)
        for title, row in rows
        if row is not None
    ]
    parts = next((section.rows for section in found if section.key == "budget"), ())
    if parts:
        cards.append(Card("dearest part, share of mean square", str(parts[0].figures[1]), parts[0].label))
    return cards


def _source(answer: Answer) -> str:
    sampled, poses = answer.sampled, answer.poses
    sets = f" in {poses.replicates} independent sets" if poses.replicates > 1 else ""
    arriving = "from either side at random" if answer.approach == 0 else "moving up" if answer.approach > 0 else "moving down"
    samples = len(poses) * sampled.robots * sampled.visits
    counts = f"{len(poses)} poses ({poses.law}){sets} x {sampled.robots} robots x {sampled.visits} visits = {samples} samples"
    return f"seed {answer.seed}: {counts}; joints arrive {arriving}. The same arm, version, seed and counts give the same bytes."
