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


def planned_sheet(found: PlannedPoses) -> Sheet:
    """Return the sheet of a plan."""
    radius, enough = found.plan.radius, found.plan.enough
    counted = several(len(found.q), "pose")
    text = (
        f"After {counted} 95 % of the mean tool points are predicted within "
        f"{length(float(radius[-1]))} of the calibrated model, before within "
        f"{length(float(radius[0]))}."
    )
    if enough is not None:
        text += f" From {several(enough, 'pose')} on five more reduce it by less than 2 % each."
    shown = sorted({0, *np.unique(np.geomspace(1, len(radius) - 1, 12).round().astype(int))})
    return Sheet(
        name=found.arm.name,
        subject="poses to measure",
        verdict=text,
        cards=(
            Card("predicted radius", str(length(float(radius[-1]))), f"after {counted}"),
            Card("before", str(length(float(radius[0]))), several(found.measured, "pose")),
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
                [(f"O{k}", value) for k, value in enumerate(found.plan.indices, 1)],
                "columns in prior deviations",
            ),
            table(
                "poses",
                "Poses in the order of a tour",
                (),
                [(f"pose {k}", joint_values(found.arm, q)) for k, q in enumerate(found.q, 1)],
            ),
        ),
        counts=f"{counted} of {CANDIDATES} candidates, noise {length(found.noise)}",
        words=_WORDS,
        source=f"{counted}, seed {found.seed}. The same file, version and seed give the same "
        "bytes.",
        seed=found.seed,
        facts={"arm": found.arm.name},
    )
