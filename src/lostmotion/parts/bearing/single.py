"""One ball or cylindrical roller bearing by itself. A joint needs two, or one of crossed rollers: a single row holds next to no moment."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NoReturn

from lostmotion.laws.rolling.table import Pair
from lostmotion.parts.bearing.pair import BallPair, RollerPair
from lostmotion.parts.bearing.rolling_contact import DrawnBearing

if TYPE_CHECKING:
    from lostmotion.parts.term import Motion

# Of the file: what a pair is called that has two of them.
PAIRS: Final = {"ball bearing": "ball pair", "roller bearing": "roller pair"}
# What only a pair has.
OF_PAIRS: Final = ("span", "arrangement", "preload")


def _one(pair: Pair, reach: float) -> Pair:
    """Return the first row of a pair alone, in the middle, with its pitch diameter where a pair has its span."""
    row = pair.seats[0].row
    return Pair((type(pair.seats[0])(row),), reach, pair.axial)


class _Single(DrawnBearing):
    """What one bearing has in common with one of another kind; stands before the class of its pair."""

    @property
    def bearings(self) -> int:
        """Return that it is one."""
        return 1

    @property
    def is_single(self) -> bool:
        """Return that no second row stands beside it."""
        return True

    def terms(self, motion: Motion) -> NoReturn:
        """Raise ValueError."""
        del motion
        raise ValueError("a single bearing is no part of an arm: a row holds next to no moment")


class SingleBallBearing(_Single, BallPair):
    """One deep-groove or angular-contact ball bearing. An angular-contact one holds towards +z only, with the radial load that this leaves."""

    @property
    def rows(self) -> Pair:
        """Return its row."""
        return _one(super().rows, self.pitch_diameter)


class SingleRollerBearing(_Single, RollerPair):
    """One cylindrical roller bearing; along the axis it holds nothing."""

    @property
    def rows(self) -> Pair:
        """Return its row."""
        return _one(super().rows, self.pitch_diameter)


def single(pair: BallPair | RollerPair) -> SingleBallBearing | SingleRollerBearing:
    """Return one bearing of a checked pair."""
    stated: dict[str, Any] = {name: getattr(pair, name) for name in type(pair).model_fields}
    kind: Any = SingleBallBearing if isinstance(pair, BallPair) else SingleRollerBearing
    out: SingleBallBearing | SingleRollerBearing = kind.model_construct(pair.model_fields_set, **stated)
    return out
