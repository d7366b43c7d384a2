"""Names of the instruments of a calibration, without what reads their files."""

from __future__ import annotations

from typing import Literal, TypeAlias

Instrument: TypeAlias = Literal[
    "tracker", "points", "poses", "distance", "plane", "sphere", "dial", "inclinometer", "tags"
]
