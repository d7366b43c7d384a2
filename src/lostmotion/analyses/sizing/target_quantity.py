"""What a target on the tool limits: the position error, or the repeatability of joints that arrive
one way.
"""

from __future__ import annotations

from typing import Final, Literal

from lostmotion.error_model.arrival import rp_name

TargetOf = Literal["error", "rp_iso", "rp_any"]
TARGETS: Final[dict[TargetOf, str]] = {
    "error": "95 % error",
    "rp_iso": f"{rp_name(1.0)}, of 95 % of robots",
    "rp_any": f"{rp_name(0.0)}, of 95 % of robots",
}


def approach_for(of: TargetOf) -> float:
    """Return the sign of the joints' last motion for a quantity: fixed in the ISO cycle, 0 where it
    is drawn at every visit.
    """
    return 1.0 if of == "rp_iso" else 0.0
