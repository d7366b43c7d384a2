"""The coarsest usual sizes: an allowance beyond them says only that the item does not limit the target.

Round values, each coarser than what makers of robot parts print: a gearbox with 60' of play, an encoder with 100 counts per turn, a bearing with
200 µm of clearance, a length held to 1 % (ISO 2768-1, class v, allows ±4 mm from 400 mm on). A stiffness scales with the arm, and parts by their
drawing have no one size: there the errors may be ten times as large.
"""

from __future__ import annotations

import math
from typing import Final

_ARCMIN: Final = math.pi / 10800
_TURNING: Final = 60 * _ARCMIN
_SLIDING: Final = 1e-3
# Of a stiffness, and of items without a size of their own.
MOST_TIMES: Final = 10.0
# Of a length's tolerance.
MOST_OF_LENGTH: Final = 0.01
# (kind of part, cause) -> largest usual size along a turning and a sliding motion, rad and m, or one length or angle for both.
_USUAL: Final[dict[tuple[str, str], dict[str, float]]] = {
    ("gearbox", "play"): {"rad": _TURNING, "m": _SLIDING},
    ("gearbox", "hysteresis"): {"rad": _TURNING, "m": _SLIDING},
    ("gearbox", "transmission error"): {"rad": _TURNING, "m": _SLIDING},
    ("bearing", "clearance"): {"m": 200e-6},
    ("bearing", "axial play"): {"m": 500e-6},
    ("bearing", "radial runout"): {"m": 100e-6},
    ("bearing", "axial runout"): {"m": 100e-6},
    ("encoder", "resolution"): {"rad": 2 * math.pi / 100, "m": _SLIDING},
    ("encoder", "noise"): {"rad": _TURNING, "m": _SLIDING},
    ("encoder", "eccentricity"): {"rad": _TURNING, "m": _SLIDING},
    ("encoder", "zero"): {"rad": _TURNING, "m": _SLIDING},
    ("mounting", "axis tilt"): {"rad": _TURNING},
    ("mounting", "axis offset"): {"m": 1e-3},
    ("tilt", "roll"): {"rad": math.radians(30)},
    ("tilt", "pitch"): {"rad": math.radians(30)},
    ("lumped", "angle"): {"rad": 3 * _TURNING, "m": 5e-3},
    ("lumped", "offset"): {"m": 5e-3},
}


def largest_usual_factor(kind: str, cause: str, value: float, unit: str, length: float = 0.0) -> float:
    """Return the factor at which an item of this size (SI, `unit`) has the largest usual one; never below one, for what is stated is made.

    kind, cause  the kind of part and the cause, as an item names them; `length` (m) of a link, for its tolerance
    """
    if (kind, cause) == ("link", "length tolerance"):
        largest = MOST_OF_LENGTH * length
    else:
        largest = _USUAL.get((kind, cause), {}).get(unit, MOST_TIMES * value)
    return max(largest / value, 1.0)
