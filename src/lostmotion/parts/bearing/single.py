"""One ball or cylindrical roller bearing by itself. A joint needs two, or one of crossed rollers: a
single row carries almost no moment.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NoReturn

from lostmotion.laws.rolling.table import Pair
from lostmotion.parts.bearing.pair import BallPair, RollerPair
from lostmotion.parts.bearing.rolling_contact import DrawnBearing

if TYPE_CHECKING:
    from lostmotion.parts.term import Motion

# Kinds of a file: the pair with two of each bearing.
PAIRS: Final = {"ball bearing": "ball pair", "roller bearing": "roller pair"}
# Fields of pairs only.
OF_PAIRS: Final = ("span", "arrangement", "preload")


def _one(pair: Pair, reach: float) -> Pair:
    """Return the first row of a pair alone, in the middle, with the pitch diameter instead of the
    span.
    """
    row = pair.seats[0].row
    return Pair((type(pair.seats[0])(row),), reach, pair.axial)


class _Single(DrawnBearing):
    """Mixin of single bearings, before the class of their pair."""

    @property
    def bearings(self) -> int:
        """Return the number of bearings, 1."""
        return 1

    @property
    def is_single(self) -> bool:
        """Return that this is a single row."""
        return True

    def terms(self, motion: Motion) -> NoReturn:
        """Raise ValueError."""
        del motion
        raise ValueError(
            "a single bearing cannot be part of an arm: one row carries almost no moment"
        )


class SingleBallBearing(_Single, BallPair):
    """One deep-groove or angular-contact ball bearing. An angular-contact one carries axial load
    towards +z only.
    """

    @property
    def rows(self) -> Pair:
        """Return its row."""
        return _one(super().rows, self.pitch_diameter)


class SingleRollerBearing(_Single, RollerPair):
    """One cylindrical roller bearing; it carries no axial load."""

    @property
    def rows(self) -> Pair:
        """Return its row."""
        return _one(super().rows, self.pitch_diameter)


def single(pair: BallPair | RollerPair) -> SingleBallBearing | SingleRollerBearing:
    """Return one bearing of a checked pair."""
    stated: dict[str, Any] = {name: getattr(pair, name) for name in type(pair).model_fields}
    kind: Any = SingleBallBearing if isinstance(pair, BallPair) else SingleRollerBearing
    out: SingleBallBearing | SingleRollerBearing = kind.model_construct(
        pair.model_fields_set, **stated
    )
    return out
