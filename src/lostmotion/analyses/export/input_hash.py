"""What identifies the input of an export."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm


def input_hash(arm: Arm) -> str:
    """Return the SHA-256 hash of everything that describes the arm, without the way in which a file
    spells it, and of the estimates of its errors.
    """
    found = hashlib.sha256(repr(arm.model_dump()).encode())
    if (calibration := arm.calibration) is not None:
        found.update(repr(calibration.streams).encode())
        for values in (calibration.mean, calibration.covariance):
            found.update(np.asarray(values, dtype=float).tobytes())
    return found.hexdigest()
