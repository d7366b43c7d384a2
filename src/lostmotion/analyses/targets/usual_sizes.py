"""Largest usual sizes of errors: an item whose allowance exceeds them does not limit the target.

Round values, each coarser than what manufacturers of robot parts state: 60' of backlash, 100
encoder counts per turn, 200 µm of bearing clearance, a length tolerance of 1 % (ISO 2768-1, class
v: ±4 mm from 400 mm on). Stiffness depends on the arm and parts by drawing have no single size;
their errors may be ten times as large.
"""

from __future__ import annotations

import math
from typing import Final

_ARCMIN: Final = math.pi / 10800
_TURNING: Final = 60 * _ARCMIN
_SLIDING: Final = 1e-3
# Largest usual factor on the errors of a stiffness, and of items without a size.
MOST_TIMES: Final = 10.0
# Largest usual length tolerance, as a share of the length.
MOST_OF_LENGTH: Final = 0.01
# (kind of part, cause) -> largest usual size by unit: of a revolute and of a prismatic joint, or
# one for both.
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
    ("servo", "dead_band"): {"rad": _TURNING, "m": _SLIDING},
    ("mounting", "axis tilt"): {"rad": _TURNING},
    ("mounting", "axis offset"): {"m": 1e-3},
    ("base", "roll"): {"rad": math.radians(30)},
    ("base", "pitch"): {"rad": math.radians(30)},
    ("lumped", "angle"): {"rad": 3 * _TURNING, "m": 5e-3},
    ("lumped", "offset"): {"m": 5e-3},
}


def largest_usual_factor(
    kind: str, cause: str, value: float, unit: str, length: float = 0.0
) -> float:
    """Return the factor from an item's size (SI, `unit`) to its largest usual one; at least 1,
    because the stated size exists.

    kind, cause  the kind of part and the cause, as an item names them; `length` (m) of a link, for
                 its tolerance
    """
    if (kind, cause) == ("link", "length tolerance"):
        largest = MOST_OF_LENGTH * length
    else:
        largest = _USUAL.get((kind, cause), {}).get(unit, MOST_TIMES * value)
    return max(largest / value, 1.0)
