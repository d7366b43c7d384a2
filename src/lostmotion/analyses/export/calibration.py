"""The argument `calibration` of the controller and its exports."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lostmotion.errors import refuse_argument

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.controller_model.calibration import Calibration


def calibration_of(name: str, value: Any, given: Mapping[str, Any]) -> Calibration:  # noqa: ANN401 - whatever a user passes
    """Return the estimates of one robot's errors, read from their file where a path is given.
    Raises InputError with every mistake in the file.
    """
    arm = given["arm"]
    if isinstance(value, str | os.PathLike):
        if not hasattr(arm, "terms"):  # the arm's own mistakes are reported already
            return value  # type: ignore[return-value]
        from lostmotion.io.calibration_file import read_calibration

        return read_calibration(Path(value), arm.terms)
    from lostmotion.controller_model.calibration import Calibration

    if not isinstance(value, Calibration):
        raise refuse_argument(
            name, value, "a calibration, or the path of its file", **{name: "robot-17.toml"}
        )
    return value
