"""The figures of calibration and compensation: what each would leave of the error."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from lostmotion.error_model.arrival import rp_name
from lostmotion.error_model.intervals import pooled_mean
from lostmotion.reporting.sheet import Cell, Row, Section, in_one_unit, length, several

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.propagation.montecarlo.repeatability import Repeatability
    from lostmotion.propagation.montecarlo.waterfall import Waterfall

# Each stage in words, in the order of the waterfall.
STAGES: Final = (
    "as manufactured",
    "constant errors of each robot identified",
    "load, pose, stated temperature, nominal stiffness and play known",
    "constant errors identified, load compensated",
    "harmonics and stiffness of each robot mapped as well",
    (
        "every joint from the same side at every visit: backlash and hysteresis become a "
        "constant, which repeats"
    ),
    "nominal backlash and hysteresis of the side of arrival compensated",
    "the same, with load, pose, stated temperature and nominal stiffness known",
    (
        "the same, with constant errors, harmonics and stiffness of each robot known: encoder, "
        "servo, friction and open clearances remain"
    ),
    (
        "an encoder on each output that leaves no play open; its error and the dead band of the "
        "servo remain, as large at the output as now"
    ),
    (
        "the load of each drive is measured: its nominal wind-up, and the side of backlash that "
        "the load closes"
    ),
)


def waterfall_section(found: Waterfall, repeats: Sequence[Repeatability]) -> Section:
    """Return the effect of calibration and compensation."""
    counted = (
        f"{several(found.poses, 'pose')} x {several(found.robots, 'robot')} x "
        f"{several(found.visits, 'visit')}, the same at every stage"
    )
    rows = []
    means, left = (
        in_one_unit([_of(each, counted) for each in column])
        for column in zip(*((s.mean, s.q95) for s in found.stages), strict=True)
    )
    for stage, text, mean, q95 in zip(found.stages, STAGES, means, left, strict=True):
        off = _of(stage.reduction, counted)
        effect = (
            f"; reduces the 95th percentile by {off} ({off.interval})"
            if stage is not found.stages[0] and off.interval
            else ""
        )
        rows.append(Row(stage.name, (mean, q95), "" if text == stage.name else text + effect))
    each = (
        f"{rp_name(each.approach)}, {_of(pooled_mean(each.robot_means, each.per_pose[:, 0]), '')}"
        for each in repeats
    )
    stays = (
        f" No calibration or compensation of the load changes RP ({'; '.join(each)} on average)."
        if repeats
        else ""
    )
    note = (
        "by Monte Carlo on a part of the poses and robots, so the first row differs from the "
        "figures above. Every remedy is ideal, "
        "a real one leaves more. Calibration removes a robot's errors that are constant in "
        f"their own frame, {several(len(found.constant), 'error')} "
        "(lengths, axes, encoder zeros). It does not find harmonics (transmission error, "
        "encoder eccentricity) and load-dependent errors: a map "
        "of each robot may find these." + stays
    )
    return Section(
        "waterfall",
        "Effect of calibration and load compensation",
        ("mean", "95th percentile"),
        tuple(rows),
        note,
    )


def rms_section(found: Mapping[str, Estimate], poses: int) -> Section:
    """Return what each remedy leaves of the root mean square (m) over so many poses, without
    sampling.
    """
    counted = f"exact sum over terms, {several(poses, 'pose')}"
    left = in_one_unit([_of(each, counted) for each in found.values()])
    rows = (
        Row(name, (figure,), "" if text == name else text)
        for name, text, figure in zip(found, STAGES, left, strict=True)
    )
    note = (
        "every remedy is ideal, a real one leaves more. Calibration does not find harmonics "
        "(transmission error, encoder eccentricity) and "
        "load-dependent errors: a map of each robot may find these"
    )
    return Section(
        "remedies", "Effect of remedies without sampling", ("root mean square",), tuple(rows), note
    )


def _of(estimate: Estimate, samples: str) -> Cell:
    return length(estimate.value, estimate.low, estimate.high, samples)
