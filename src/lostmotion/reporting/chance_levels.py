"""What can be done about each level of chance, in the words that every table uses."""

from __future__ import annotations

from typing import Final

# Load and pose, each robot, each visit.
REMEDIES: Final = (
    "a controller that knows the load, and the temperature where one is stated, can compensate it",
    "calibration can remove what is constant; a map of each robot the rest",
    (
        "a known side of arrival removes the side of backlash and hysteresis; the rest only other "
        "parts"
    ),
)
INTERVAL_OF_POSES: Final = (
    "r.m.s. errors are exact at the poses visited; the interval shows what the choice of poses "
    "leaves"
)
