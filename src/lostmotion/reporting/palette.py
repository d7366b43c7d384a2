"""Colours of every chart and page, light and dark, and the seven classes of a coloured map.

The classes run from small to large error through teal, blue, purple and crimson. Their lightness
moves away from the paper in both schemes, so a large error stands out, and it is monotone for
readers with any of the three colour-vision deficiencies (G. M. Machado et al., IEEE TVCG 15 (2009)
1291).
"""

from __future__ import annotations

import math
from typing import Final

LIGHT: Final = {
    "paper": "#ffffff",
    "panel": "#f6f8fa",
    "ink": "#1a2027",
    "quiet": "#56616c",
    "line": "#d5dbe1",
    "accent": "#0b5c9e",
    "design": "#c27a0e",
    "robot": "#2f74b5",
    "visit": "#12806a",
    "warn": "#a83200",
    "other": "#9a4f96",
    "c0": "#bee8e2",
    "c1": "#71cde7",
    "c2": "#5ba2ee",
    "c3": "#7970d5",
    "c4": "#844496",
    "c5": "#712a4e",
    "c6": "#48201e",
}
DARK: Final = {
    "paper": "#11161c",
    "panel": "#181f27",
    "ink": "#e7ecf1",
    "quiet": "#9aa7b4",
    "line": "#2b343e",
    "accent": "#7cb8f2",
    "design": "#f0a93c",
    "robot": "#6fb0ee",
    "visit": "#4cc3a5",
    "warn": "#ff9a6b",
    "other": "#d992d4",
    "c0": "#004e47",
    "c1": "#05667a",
    "c2": "#1876cb",
    "c3": "#877cf1",
    "c4": "#d587ec",
    "c5": "#feaacf",
    "c6": "#fedbd7",
}
CLASSES: Final = tuple(LIGHT[f"c{k}"] for k in range(7))
# Levels of chance, by the names that tables use.
LEVELS: Final = (
    ("load and pose", LIGHT["design"]),
    ("each robot", LIGHT["robot"]),
    ("each visit", LIGHT["visit"]),
)
LEVEL_NAMES: Final = tuple(name for name, _ in LEVELS)
# Colours of loads by cause.
OF_CAUSE: Final = {
    "payload": LIGHT["robot"],
    "process force": LIGHT["warn"],
    "tool": LIGHT["quiet"],
    "links": LIGHT["visit"],
    "joints and drives": LIGHT["design"],
    "own weight": LIGHT["other"],
}


def css_variables(*, dark: bool = False) -> str:
    """Return the colours as CSS custom properties: `--paper`, `--ink`, ..., `--c0` to `--c6`."""
    return "".join(f"--{name}:{colour};" for name, colour in (DARK if dark else LIGHT).items())


def round_below(most: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that is not above a number, which is
    above zero.
    """
    power = 10.0 ** math.floor(math.log10(most))
    return max(step * power for step in (1, 2, 5) if step * power <= most)


def class_limits(low: float, high: float) -> list[float]:
    """Return the six limits between seven classes of values from `low` to `high`, in steps of 1, 2
    or 5 times a power of ten.

    The step is the smallest of which seven cover the range; the first and the last class hold what
    lies beyond. Equal ends give limits about them; ends that are not finite are taken as 0 and 1.
    """
    if not (math.isfinite(low) and math.isfinite(high)):
        low, high = 0.0, 1.0
    count = len(CLASSES)
    span = max(high - low, 1e-3 * abs(high)) or 1.0
    power = math.floor(math.log10(span / count))
    steps = (multiple * 10.0**exponent for exponent in (power, power + 1) for multiple in (1, 2, 5))
    step = next(each for each in steps if each * count >= span * (1 - 1e-9))
    first = round(((low + high) / 2 - (count - 2) * step / 2) / step)
    if low >= 0:
        first = max(first, 1)
    places = max(0, -math.floor(math.log10(step) + 1e-9))
    return [round((first + k) * step, places) for k in range(count - 1)]
