"""Limits of a target's quantities."""

from __future__ import annotations

from typing import Final

from lostmotion.units import Quantity

LENGTH: Final = Quantity("m", "0.5 mm", above=0, high=100)
SHARE: Final = Quantity("", "95 %", low=0.5, high=0.999)
