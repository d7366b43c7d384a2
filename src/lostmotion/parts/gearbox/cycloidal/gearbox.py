"""A cycloidal gearbox from its drawing, and the error sources that follow from it."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from pydantic import PrivateAttr

from lostmotion.laws.distributions import Normal
from lostmotion.parts.gearbox.cycloidal.drawing import CycloidalDrawing
from lostmotion.parts.gearbox.cycloidal.materials import material_shares
from lostmotion.parts.gearbox.cycloidal.model import ANGLES, Behaviour, behaviour
from lostmotion.parts.gearbox.cycloidal.names import CONTACTS
from lostmotion.parts.gearbox.cycloidal.samples import GEARBOXES, gearboxes
from lostmotion.parts.gearbox.cycloidal.sources import GearboxWindUp, Play, TransmissionError
from lostmotion.parts.gearbox.cycloidal.temperature import follows, growth_is_known
from lostmotion.units import Toleranced

if TYPE_CHECKING:
    from lostmotion.parts.error_source import ErrorSource
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage


class CycloidalGearbox(CycloidalDrawing):
    """A cycloidal gearbox: the output stage, with an optional first stage, input shaft and frame.

    rated_torque     at the output; the wind-up is computed up to 2.5 times this torque, and
                     extrapolated linearly beyond
    fixed            "ring" (the disc, or its carrier, is the output) or "carrier" (the ring is)
    first_stage      planetary (RV) or cycloidal; default: the input turns the eccentric
    frame            torsional stiffness of housing and output shaft, at the output; or a table of
                     its screws and of the housing as a tube
    input_shaft      torsional stiffness at the input; default: that of the eccentric's shaft up to
                     its first disc, where its sections are stated
    rigid            names of members declared rigid; others that the drawing does not describe are
                     bounded
    friction_torque  at the output without load (seals, preload), included in the hysteresis. Under
                     a load below it the play stays open; default: 1 % of the rated torque for the
                     play, and none in the hysteresis. ± is its scatter over gearboxes, of the play
                     alone; default: ±50 %
    hysteresis_scatter  ± share by which the width of the friction loop differs from visit to visit,
                        three standard deviations
    unstated         factors on the compliance of what the drawing leaves open, by name: each is a
                     range unless stated
    mass, price, inertia  of the gearbox, the last at its input, as for `Gearbox`
    """

    # the drawing of a gearbox that an arm takes to its temperature
    _drawn: CycloidalGearbox | None = PrivateAttr(None)

    @functools.cached_property
    def behaviour(self) -> Behaviour:
        """Return the behaviour of gearboxes of this drawing, computed once per drawing."""
        return behaviour(self)

    @functools.cached_property
    def members(self) -> dict[str, ErrorSource]:
        """Return the error sources by name: play, transmission error, friction, and every spring
        that is not rigid.
        """
        out, drawn = sources(self, self.behaviour), self._drawn or self
        play = out.get("play")
        if isinstance(play, Play) and drawn.follows_temperature:
            out["play"] = replace(play, per_kelvin=drawn.play_per_kelvin)
        return out

    def play_per_kelvin(self, rise: Toleranced) -> float:
        """Return the change of the mean play per kelvin within the ± of the temperature rise of its
        arm, rad/K.
        """
        ends = (self.warmed(Toleranced(rise.nominal + sign * rise.tolerance)) for sign in (1, -1))
        hot, cold = (gearboxes(each, np.empty(0), ANGLES, GEARBOXES).play.mean() for each in ends)
        return float(hot - cold) / (2 * rise.tolerance)

    @property
    def follows_temperature(self) -> bool:
        """Return whether its clearances follow the temperature of its arm."""
        return any(follows(stage) for stage in self._stages)

    @property
    def expansion_unknown(self) -> bool:
        """Return whether parts that set its clearances state no expansion."""
        return not all(growth_is_known(stage) for stage in self._stages)

    @property
    def _stages(self) -> tuple[CycloidalStage, ...]:
        first = self.cycloidal_first_stage
        return (self,) if first is None else (self, first)

    def warmed(self, rise: Toleranced | None) -> CycloidalGearbox:
        """Return this gearbox at the temperature rise of its arm, K; itself where that changes no
        clearance.
        """
        return (
            self
            if rise is None or not rise.nominal or not self.follows_temperature
            else _at_rise(self, rise.nominal)
        )


@functools.lru_cache(maxsize=64)
def _at_rise(gearbox: CycloidalGearbox, rise: float) -> CycloidalGearbox:
    first, warm = gearbox.cycloidal_first_stage, {"temperature_rise": rise}
    changes: dict[str, object] = {**warm} if follows(gearbox) else {}
    if first is not None and follows(first):
        changes["first_stage"] = first.model_copy(update=warm)
    out = gearbox.model_copy(update=changes)
    out._drawn = gearbox  # noqa: SLF001 - of the same class
    return out


def sources(gearbox: CycloidalDrawing, mechanism: Behaviour) -> dict[str, ErrorSource]:
    """Return the error sources of a gearbox of this drawing by name, without those that are zero.

    Play and wind-up are drawn independently. In a real gearbox they partly cancel, because a flank
    that makes contact early also deflects first: their joint scatter is overestimated by up to a
    third.
    """
    out: dict[str, ErrorSource] = {}
    play = float(mechanism.play.mean())
    if play > 0:
        # a normal distribution of the same mean and deviation, truncated at zero play
        limit = min(float(mechanism.play.std()) * Normal().bound, play)
        out["play"] = Play(Toleranced(play, limit), gearbox.friction_at_rest)
    materials: dict[str, list[tuple[str, float]]] = {}
    for each in material_shares(gearbox):
        for name, share in each.shares.items():
            if each.material.scatter:
                materials.setdefault(name, []).append((each.name, share * each.material.scatter))
    for name, angle in mechanism.wind_up.items():
        if angle.any():
            scatter = mechanism.scatter if name == CONTACTS else None
            out[name] = GearboxWindUp(
                mechanism.torque, angle, scatter, tuple(materials.get(name, ()))
            )
    if mechanism.harmonics:
        out["transmission error"] = TransmissionError(
            mechanism.harmonic_torque, mechanism.harmonics
        )
    if mechanism.friction.any:
        out["friction"] = replace(mechanism.loop, scatter=gearbox.hysteresis_scatter)
    return out
