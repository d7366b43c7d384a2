"""Studies of an arm: by samples or sums over terms, in zones, and by class of drive."""

from __future__ import annotations

from typing import Literal

Method = Literal["montecarlo", "analytic", "both"]
