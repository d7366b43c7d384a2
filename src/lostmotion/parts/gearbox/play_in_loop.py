"""Play of a gearbox within the control loop of an encoder on its output."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from lostmotion.laws.distributions import Uniform, of_tolerance
from lostmotion.parts.error_source import ErrorSource, Grouped
from lostmotion.parts.play import Seat
from lostmotion.parts.standard_terms import End, free_terms, parameter
from lostmotion.parts.term import Draw, Parameter

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.parts.error_source import Friction
    from lostmotion.parts.term import Holding, Motion, Term
    from lostmotion.units import Toleranced


@runtime_checkable
class HasPlay(Protocol):
    """A source with a free play."""

    @property
    def play(self) -> Toleranced:
        """Return the full free play, rad or m."""

    def play_friction(self, holding: Callable[[], Holding]) -> Friction | None:
        """Return the load below which the play stays open; None without play."""


@dataclass(frozen=True, slots=True)
class PlayInLoop(ErrorSource):
    """Play of a gearbox under an output encoder, open where the load is below friction; `dead_band`
    ± rad or m, None: all of the play.

    Above friction the flanks are closed and the controller corrects the output. Below it only
    friction holds the output: it rests within the dead band, or hunts between the flanks. Its
    position is then uniformly distributed over the play, or over the dead band where that is
    smaller; with an encoder on the motor it lies at one flank or the other. The half-width is
    min(play / 2, dead_band) times the free share of `laws.clearance`.
    """

    gearbox: HasPlay
    dead_band: float | None

    @property
    def play(self) -> Toleranced:
        """Return the full free play."""
        return self.gearbox.play

    def play_friction(self, holding: Callable[[], Holding]) -> Friction | None:
        """Return the friction of the gearbox."""
        return self.gearbox.play_friction(holding)

    def terms(self, motion: Motion) -> list[Term]:
        """Return the position within the open play, drawn at every visit and independent of the
        last motion.
        """
        friction, play = self.play_friction(motion.holding), self.play
        if friction is None or not play.nominal:
            return []
        # A dead band well inside the play does not scatter with it.
        within = self.dead_band is not None and self.dead_band < play.nominal / 2
        half, spread = (
            (self.dead_band or 0.0, 0.0)
            if within
            else (play.nominal / 2, play.tolerance / of_tolerance(play.law).bound / 2)
        )
        name = "dead band" if within else "backlash left open"
        sized = Parameter(name) if within else parameter("play", play.nominal, motion.unit)
        law, amount = Uniform(), Draw("amount", of_tolerance(play.law))
        ends = [End(name, motion.twist, Draw("rest", law))]
        return free_terms(
            name,
            Seat(motion.twist[None], friction.load),
            ends,
            half / law.bound,
            spread / law.bound,
            amount,
            sized,
        )


def play_left_open(gearbox: object, dead_band: float | None) -> dict[str, ErrorSource]:
    """Return by name the play of a gearbox within the control loop of an encoder on its output;
    empty without play. `dead_band` as `PlayInLoop`.
    """
    with_play = gearbox.members.get("play") if isinstance(gearbox, Grouped) else gearbox
    return (
        {"gearbox": PlayInLoop(with_play, dead_band)}
        if isinstance(with_play, HasPlay) and with_play.play.nominal
        else {}
    )
