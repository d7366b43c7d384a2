"""Remedies against errors, each as the columns of the pose matrix that it removes.

Calibrated          removes every error drawn per robot that is a constant screw in the frame of its place: lengths, axis tilts and offsets, encoder
                    zeros, base tilt. An ideal identification of the geometry finds these. It does not find harmonics (transmission error, encoder
                    eccentricity, runout), which require a table per joint, nor errors that depend on the load (scatter of stiffness, size of a play
                    that a load closes). Errors that are the same in every robot are removed by compensation, also constant ones.
Load compensated    removes every design term: the controller knows pose, load, nominal stiffness and nominal play exactly.
Mapped              removes every error drawn per robot, including harmonics and errors that depend on the load. The remaining errors differ from
                    visit to visit, including the size of a free play. No remedy removes them.

Each remedy is ideal, so the remaining error is a lower limit for a real one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.pose_matrix import screws

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.pose_matrix import Column, PoseMatrix
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

STAGES: Final = ("as manufactured", "calibrated", "load compensated", "both", "both, and each robot mapped")


def remaining(infos: Sequence[Column], stage: str, geometry: frozenset[str]) -> Floats:
    """Return 1 for each column that remains at a stage of `STAGES`, else 0 (column,); `geometry`: names of terms that ideal calibration finds."""
    calibrated = stage in {"calibrated", "both"}
    compensated = stage in {"load compensated", "both", "both, and each robot mapped"}
    mapped = stage == "both, and each robot mapped"
    removed = [
        (calibrated and info.name in geometry) or (compensated and info.level == "design") or (mapped and info.level == "robot") for info in infos
    ]
    return 1.0 - np.array(removed, dtype=float)


def geometry_of(arm: Arm) -> frozenset[str]:
    """Return the names of the terms that an ideal calibration of the geometry finds: drawn per robot, with a constant screw."""
    return frozenset(of.name for of in arm.terms if of.term.level == "robot" and not of.term.form.reads)


def screws_at_stage(arm: Arm, q: Floats, stage: str, *, approach: float = 0.0) -> PoseMatrix:
    """Return the pose matrix of the errors that remain at a stage of `STAGES`; other arguments and errors as for `screws`."""
    matrix = screws(arm, q, approach=approach)
    return matrix if stage == STAGES[0] else matrix.scaled(remaining(matrix.infos, stage, geometry_of(arm)))
