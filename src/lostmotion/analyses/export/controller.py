"""The controller of an arm in Python."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.analyses.arguments import arm_of
from lostmotion.analyses.quantities import amount
from lostmotion.blas_threads import one_blas_thread
from lostmotion.controller_model.controller import Controller
from lostmotion.controller_model.lowering import tables_of
from lostmotion.controller_model.validity import validity_of
from lostmotion.error_model.provenance import refuse_undescribed
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.calibration import Calibration


def controller(
    arm: Arm | str | Path,
    *,
    largest_payload: float | str | None = None,
    calibration: Calibration | str | Path | None = None,
    accurate_length: bool = False,
) -> Controller:
    """Return the controller of an arm: `predict` and `compensate` on tables, with the formulas of
    the C sources.

    Parameters
    ----------
    arm
        An arm, or its file.
    largest_payload
        Largest payload, in kg or as text with a unit, for which it answers. Default: twice the
        payload of the file, or the mass of the arm where none is stated.
    calibration
        Estimates of the errors of one robot, or their file. Default: none.
    accurate_length
        Whether the 95th percentile of the length is computed within 0.2 % instead of 1.5 %, which
        takes longer.

    Raises
    ------
    InputError
        With every mistake in the files, for a payload that is not positive, for an arm without any
        error source, and for a calibration of draws that the arm does not have.

    """
    described = arm_of("arm", arm, {"calibration": calibration})
    refuse_undescribed(described)
    payload = (
        None
        if largest_payload is None
        else amount("largest_payload", largest_payload, Quantity("kg", "10 kg", above=0))
    )
    with one_blas_thread():
        tables = tables_of(described, validity_of(described, payload))
    return Controller(tables, accurate_length=accurate_length)
