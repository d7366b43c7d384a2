"""The controller of an arm in Python."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.analyses.arguments import arm_of
from lostmotion.controller_model.controller import Controller
from lostmotion.controller_model.lowering import tables_of
from lostmotion.controller_model.validity import validity_of

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.controller_model.calibration import Calibration
    from lostmotion.mechanism.arm import Arm


def controller(
    arm: Arm | str | Path, *, payload: float | None = None, calibration: Calibration | None = None, accurate_length: bool = False
) -> Controller:
    """Return the controller of an arm: `predict` and `compensate` on tables, with the formulas of the C sources.

    Parameters
    ----------
    arm
        An arm, or its file.
    payload
        Largest payload in kg for which it answers. Default: twice the payload of the file, or the mass of the arm where none is stated.
    calibration
        Estimates of the errors of one robot. Default: none.
    accurate_length
        Whether the 95th percentile of the length is computed within 0.2 % instead of 1.5 %, which takes longer.

    Raises
    ------
    InputError
        With every mistake in the file.

    """
    described = arm_of("arm", arm, {})
    terms = None if calibration is None else calibration.terms(described.terms)
    return Controller(tables_of(described, validity_of(described, payload), terms), accurate_length=accurate_length)
