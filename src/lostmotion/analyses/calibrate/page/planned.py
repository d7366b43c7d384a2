"""Sheet of poses to measure next."""

from __future__ import annotations

from typing import Final

import numpy as np

from lostmotion.analyses.calibrate.answer import CANDIDATES, PlannedPoses
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.sheet import Card, Sheet, length, several, table

_WORDS: Final = (
    (
        "predicted radius",
        (
            "95 % of the mean tool points are within it of where the calibrated model puts them, "
            "mean over the working poses; scatter between visits is not included."
        ),
    ),
    (
        "O1 to O5",
        (
            "observability indices: geometric mean of the singular values, smallest over largest, "
            "smallest, its square over the largest, one over the sum of inverses."
        ),
    ),
)


def planned_sheet(planned: PlannedPoses) -> Sheet:
    """Return the sheet of a plan."""
    radius, enough = planned.plan.radius, planned.plan.enough
    counted = several(len(planned.q), "pose")
    text = (
        f"After {counted} 95 % of the mean tool points are predicted within "
        f"{length(float(radius[-1]))} of the calibrated model, before within "
        f"{length(float(radius[0]))}."
    )
    if enough is not None:
        text += f" From {several(enough, 'pose')} on five more reduce it by less than 2 % each."
    shown = sorted({0, *np.unique(np.geomspace(1, len(radius) - 1, 12).round().astype(int))})
    return Sheet(
        name=planned.arm.name,
        subject="poses to measure",
        verdict=text,
        cards=(
            Card("predicted radius", str(length(float(radius[-1]))), f"after {counted}"),
            Card("before", str(length(float(radius[0]))), several(planned.measured, "pose")),
        ),
        sections=(
            table(
                "radius",
                "Predicted radius by the number of poses",
                ("95 % radius",),
                [(several(int(k), "pose"), length(float(radius[k]))) for k in shown],
            ),
            table(
                "observability",
                "Observability of the chosen poses",
                ("value",),
                [(f"O{k}", value) for k, value in enumerate(planned.plan.indices, 1)],
                "columns in prior deviations",
            ),
            table(
                "poses",
                "Poses in the order of a tour",
                (),
                [(f"pose {k}", joint_values(planned.arm, q)) for k, q in enumerate(planned.q, 1)],
            ),
        ),
        counts=f"{counted} of {CANDIDATES} candidates, noise {length(planned.noise)}",
        words=_WORDS,
        source=f"{counted}, seed {planned.seed}. The same file, version and seed give the same "
        "bytes.",
        seed=planned.seed,
        facts={"arm": planned.arm.name},
    )
