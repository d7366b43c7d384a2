"""Which parts of the flanks are meshed as contacts: those that Hertz's law expects to touch, with a
margin that grows where it is too small.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.cycloid.finite_elements.contours import contacts
from lostmotion.laws.cycloid.finite_elements.envelope import envelope_contacts
from lostmotion.laws.cycloid.geometry import arms, contact_radius

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.finite_elements.contours import Contacts
    from lostmotion.laws.cycloid.finite_elements.envelope import EnvelopeContacts
    from lostmotion.laws.cycloid.stage import Modification, Stage
    from lostmotion.spatial import Floats

# Half-width of a contact that is meshed, over Hertz's; the factor by which it grows where pressure
# reaches its edge.
_REACH: Final = 1.3
_GROWTH: Final = 1.5
# Smallest load, over the largest, for which a contact is meshed.
_LEAST_LOAD: Final = 0.3
# Pitches past those with an arm at which contacts are meshed: the bodies deform, and may close
# them.
_BEYOND: Final = 1.01


class OnPins:
    """Contacts with pins or plain arcs. Lengths in m."""

    def __init__(self, stage: Stage, crank: float, load: float, intervals: int) -> None:
        """Choose the contacts under a load per width of the most loaded pin, over the equivalent
        modulus, m.
        """
        self._made, self._intervals, self._beyond = contacts(stage, crank), intervals, _BEYOND
        share = np.maximum(self._made.arm / stage.planet_pitch_radius, _LEAST_LOAD)
        self._half = _REACH * np.sqrt(4 * load * share * self._made.radius / math.pi)

    def chosen(self) -> tuple[Contacts, dict[int, Floats]]:
        """Return the contacts, and the ends of the intervals of those that are meshed. Raises
        DidNotConvergeError where one outgrows its pin.
        """
        return self._made, {
            k: _places(self._made, k, self._half[k], self._intervals)
            for k in _candidates(self._made, self._beyond)
        }

    def grow(self, at: dict[int, Floats], reach: Floats, *, at_last: bool) -> None:
        """Widen the contacts that should reach farther (`System.outgrown`), and mesh more contacts
        where an outermost one carries.
        """
        self._half[list(at)] *= np.where(reach > 0, _GROWTH * reach, 1.0)
        self._beyond += at_last


class OnEnvelope:
    """Contacts with an envelope ring: where the gap is below that at the edge of a Hertz contact, 2
    w/(pi E*), whatever its curvature.
    """

    def __init__(
        self, stage: Stage, crank: float, load: float, intervals: int, relief: Modification
    ) -> None:
        """Choose the contacts as `OnPins`; relief is that of the disc."""
        self._stage, self._crank, self._load, self._intervals, self._relief = (
            stage,
            crank,
            load,
            intervals,
            relief,
        )
        self._reach = _REACH

    def chosen(self) -> tuple[EnvelopeContacts, dict[int, Floats]]:
        """Return the contacts, and the ends of the intervals of each."""
        return envelope_contacts(self._stage, self._crank, self._relief, self._closest, self._step)

    def grow(self, _at: dict[int, Floats], _reach: Floats, *, at_last: bool) -> None:  # noqa: ARG002
        """Widen all contacts."""
        self._reach *= _GROWTH

    def _share(self, theta: Floats) -> Floats:
        return np.asarray(
            np.maximum(arms(self._stage, theta) / self._stage.planet_pitch_radius, _LEAST_LOAD)
        )

    def _closest(self, theta: Floats) -> Floats:
        return np.asarray(self._reach**2 * 2 * self._load / math.pi * self._share(theta))

    def _step(self, theta: Floats) -> Floats:
        half = np.sqrt(
            4
            * self._load
            * self._share(theta)
            * np.abs(contact_radius(self._stage, theta))
            / math.pi
        )
        return np.asarray(2 * _REACH * half / self._intervals)


def _candidates(made: Contacts, beyond: float) -> list[int]:
    """Return the contacts with an arm, and those up to `beyond` pitches farther: bodies that deform
    may close them. In order of their angle.
    """
    pitch = 2 * math.pi / made.stage.pins
    past = (made.theta + beyond * pitch) % (2 * math.pi)
    near = (
        np.flatnonzero((past > 0) & (past < math.pi + 2 * beyond * pitch))
        if beyond * pitch < math.pi / 2
        else np.arange(made.stage.pins)
    )
    return [int(k) for k in near[np.argsort(past[near])]]


def _places(made: Contacts, k: int, half: float, intervals: int) -> Floats:
    """Return the ends of the intervals of contact k (m), cut where the pin's free arc ends."""
    against, along = (float(end[k]) for end in made.free_arc())
    if half > max(against, along):
        raise DidNotConvergeError(
            "the contacts outgrow their lobes: take a smaller torque or a stiffer material"
        )
    return np.linspace(-min(half, against), min(half, along), intervals + 1)
