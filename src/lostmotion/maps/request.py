"""Arguments of an accuracy map."""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real
from typing import Final

from lostmotion.errors import refuse_argument
from lostmotion.maps.cell_statistics import (
    CONFIGURATIONS,
    Configuration,
)

SAMPLED: Final = 131_072


PER_CELL: Final = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class MapRequest:
    """Arguments of a map; lengths in m.

    cell         edge of the cells; None: chosen automatically
    by, level    configuration of the arm by which a cell is evaluated, and probability of its
                 quantile
    target       acceptable error
    box          three sides of the box to be placed; box_by_mean: by the mean of its cells, else by
                 the worst; turned: at other yaws as well clear, floor smallest distance of the box
                 from the base's z axis, and its lowest height
    poses        number of sampled poses; per_cell: number of configurations in a cell
    """

    cell: float | None = None
    by: Configuration = "mean"
    level: float = 0.95
    target: float | None = None
    box: tuple[float, float, float] | None = None
    box_by_mean: bool = False
    turned: bool = False
    clear: float = 0.0
    floor: float = -math.inf
    poses: int = SAMPLED
    per_cell: int = PER_CELL

    def __post_init__(self) -> None:
        """Refuse invalid arguments, one message each."""
        if self.by not in CONFIGURATIONS:
            raise refuse_argument("by", self.by, "one of " + ", ".join(CONFIGURATIONS), by="best")
        self._refuse_kinds()
        if not 0.25 <= self.level <= 0.9995:  # noqa: PLR2004 - as `analytic`
            raise refuse_argument("level", self.level, "a share from 0.25 to 0.9995", level=0.95)
        if self.target is not None and not (math.isfinite(self.target) and self.target > 0):
            raise refuse_argument("target", self.target, "a length above zero, m", target=0.0005)
        if self.box is not None and (
            len(self.box) != 3  # noqa: PLR2004
            or not all(math.isfinite(x) and x >= 0 for x in self.box)
            or not any(self.box)
        ):
            raise refuse_argument(
                "box",
                self.box,
                "three lengths along x, y and z, m, one above zero at least",
                box=(0.3, 0.2, 0.1),
            )
        if not (math.isfinite(self.clear) and self.clear >= 0):
            raise refuse_argument("clear", self.clear, "a length, zero or more, m", clear=0.2)
        if math.isnan(self.floor):
            raise refuse_argument("floor", self.floor, "a height, m", floor=0.0)
        if not 2 <= self.per_cell <= 1024:  # noqa: PLR2004 - best and worst differ only with two
            raise refuse_argument(
                "per_cell", self.per_cell, "from 2 to 1024 poses", per_cell=PER_CELL
            )

    def _refuse_kinds(self) -> None:
        """Refuse lengths that are not numbers, and arguments of a box without a box."""
        for name in ("cell", "target", "clear", "floor"):
            if not isinstance(getattr(self, name), Real | None):
                raise refuse_argument(
                    name, getattr(self, name), "a number of metres", **{name: "50 mm"}
                )
        for name in ("box_by_mean", "turned", "clear", "floor"):
            if (
                self.box is None
                and getattr(self, name) != type(self).__dataclass_fields__[name].default
            ):
                raise refuse_argument(
                    name,
                    getattr(self, name),
                    "a box, to which alone it applies",
                    box=(0.3, 0.2, 0.1),
                )
