"""How joints arrive at a pose. A repeatability RP depends on it, so that its name always states it.

ISO 9283 visits every pose from the same direction, 30 times: each joint arrives from one side, and
backlash and hysteresis add a constant. Where joints arrive from either side at random, backlash
that no load closes and hysteresis count as well.
"""

from __future__ import annotations

from typing import Final

ISO_CYCLE: Final = "ISO cycle"
ANY_APPROACH: Final = "any approach"


def arrival(approach: float) -> str:
    """Return how joints arrive: `approach` is the sign of their last motion, 0 where it is drawn at
    every visit.
    """
    return ISO_CYCLE if approach else ANY_APPROACH


def rp_name(approach: float) -> str:
    """Return the name of the repeatability of joints that arrive this way ("RP, ISO cycle");
    `approach` as in `arrival`.
    """
    return f"RP, {arrival(approach)}"


def rp_key(approach: float) -> str:
    """Return the key of the repeatability of joints that arrive this way ("rp_iso", "rp_any");
    `approach` as in `arrival`.
    """
    return "rp_iso" if approach else "rp_any"
