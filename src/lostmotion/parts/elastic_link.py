"""A link behind its joint: its error terms, at the link's tip and in the tip's axes."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.laws.distributions import Normal, of_tolerance
from lostmotion.parts.error_source import (
    ErrorSource,
)
from lostmotion.parts.forms import Constant, Linear
from lostmotion.parts.frame import unit
from lostmotion.parts.standard_terms import ENVIRONMENT, VARIATION, limit_terms, parameter, varying
from lostmotion.parts.term import Motion, Parameter, Term
from lostmotion.spatial import skew

if TYPE_CHECKING:
    from lostmotion.laws import beam
    from lostmotion.parts.link import Link
    from lostmotion.spatial import Floats


class ElasticLink(ErrorSource):
    """A link behind its joint; its terms act at the link's tip, in the tip's axes.

    Its deflection is linear in the wrench on its tip and in gravity: the deflections under the
    loads of each cause add up to the total.
    """

    def __init__(self, link: Link, joint_axis: Floats) -> None:
        """Compute what does not depend on the pose."""
        self.link = link
        self.tip_from_joint = link.tip_pose[:3, :3].T
        self.joint_axis = joint_axis

    def terms(self, motion: Motion) -> list[Term]:
        """Return bending under the load on the tip, bending under its own weight, the length
        tolerance, and thermal expansion.
        """
        tip = [] if self.link.tip_tolerance is None else self.link.tip_tolerance.terms()
        return [
            *self._length(),
            *tip,
            *([] if self.link.is_rigid else self._bending()),
            *self._growth(motion),
            *self._thermal_bending(motion),
        ]

    def _length(self) -> list[Term]:
        link = self.link
        if link.length.tolerance:
            along, limit, law = (
                unit(link.direction),
                link.length.tolerance,
                of_tolerance(link.length.law),
            )
        else:
            limit, law = link.length_tolerance or link.process_tolerance, of_tolerance("normal")
            if not limit:
                return []
            along = link.tip_pose[:3, 3] / link.reach
        form = Constant(np.concatenate([np.zeros(3), self.tip_from_joint @ along]))
        return limit_terms("length", form, limit, law, parameter("length tolerance", limit, "m"))

    def _bending(self) -> list[Term]:
        sized, scatters = Parameter("stiffness"), self._beam[1]
        own = Linear(np.zeros((6, 6)), self.own_weight_compliance)
        out = [
            Term(
                "bending under load",
                "bending under load",
                Linear(self.tip_compliance),
                parameter=sized,
                exponent=-1,
            ),
            Term("sag under own weight", "sag under own weight", own, parameter=sized, exponent=-1),
        ]
        for k, scatter in enumerate(scatters):
            if scatter:
                form = Linear(self._compliance_by_cause[k], self._sag_by_cause[k])
                cause = (
                    "stiffness scatter" if len(scatters) == 1 else "stiffness scatter of material"
                )
                name = cause if len(scatters) == 1 else f"{cause} {k + 1}"
                out += limit_terms(name, form, scatter, Normal(), sized, exponent=-1, cause=cause)
        return out

    def _growth(self, motion: Motion) -> list[Term]:
        """Return the expansion by the temperature rise of the whole arm, and by how far that
        differs: one draw for all links.
        """
        link, rise = self.link, motion.rise
        if rise is None or not link.expands:
            return []
        per_kelvin, sized, out = self.expansion[:, 0], Parameter("thermal expansion"), []
        if rise.nominal:
            form = Linear(np.zeros((6, 6)), per_kelvin=per_kelvin)
            out.append(Term("thermal expansion", "thermal expansion", form, parameter=sized))
        return out + varying(
            VARIATION, Constant(per_kelvin), rise, motion, sized, shared=ENVIRONMENT
        )

    def _thermal_bending(self, motion: Motion) -> list[Term]:
        """Return the bending by the stated temperature difference across the link."""
        difference = self.link.temperature_difference
        if not self.link.bends_with_temperature:
            return []
        form, sized = (
            Constant(self.expansion[:, 1]),
            parameter("temperature difference", difference.nominal, "K"),
        )
        mean = Term("thermal bending", "thermal bending", form, difference.nominal, parameter=sized)
        return [
            *([mean] if difference.nominal else []),
            *varying("temperature difference variation", form, difference, motion, sized),
        ]

    @functools.cached_property
    def expansion(self) -> Floats:
        """Return the twist of the tip (6, 2) in its axes per kelvin of temperature rise, and of
        difference across the link, rad and m; NaN: not known.
        """
        return np.asarray(np.kron(np.eye(2), self._to_tip) @ self.link.thermal_expansion)

    @functools.cached_property
    def tip_compliance(self) -> Floats:
        """Return the twist of the tip per wrench on it (6, 6), both in the tip's axes."""
        return np.asarray(self._compliance_by_cause.sum(axis=0))

    @functools.cached_property
    def own_weight_compliance(self) -> Floats:
        """Return the twist of the tip per gravity (6, 3), both in the tip's axes.

        The weight is distributed along the beam as in its sections. Around a stated centre of mass
        it is uniform on both sides, up to the nearer end: over the whole beam for a centre in the
        middle, at a point for one at an end. A centre beside the beam, or beyond its ends, adds the
        moment of the weight there.
        """
        return np.asarray(self._sag_by_cause.sum(axis=0))

    @functools.cached_property
    def _to_tip(self) -> Floats:
        return self.tip_from_joint @ self.link.beam_axes(self.joint_axis)

    @functools.cached_property
    def _beam(self) -> tuple[beam.Beam, tuple[float, ...]]:
        if self.link.is_rigid:
            raise ValueError("a rigid link has no compliance")
        return self.link.beam_in(self._to_tip)

    @functools.cached_property
    def _compliance_by_cause(self) -> Floats:
        """Return the tip's compliance by cause (cause, 6, 6)."""
        turn6 = np.kron(np.eye(2), self._to_tip)
        return np.asarray(turn6 @ self._beam[0].compliance_at(self.link.reach) @ turn6.T)

    @functools.cached_property
    def _sag_by_cause(self) -> Floats:
        """Return the twist of the tip per gravity by cause (cause, 6, 3)."""
        link, made = self.link, self._beam[0]
        if link.compliance is not None and link.compliance.own_weight is not None:
            return np.array(link.compliance.own_weight)[None]
        arm = np.zeros((3, 3))
        if link.centre_of_mass is None:
            spread = made.tip_under_own_mass()
        else:
            centre = link.beam_axes(self.joint_axis).T @ link.mass_centre
            middle = min(max(float(centre[0]), 0.0), link.reach)
            half = min(middle, link.reach - middle)
            spread = made.tip_under_uniform_load(middle - half, middle + half)
            arm = skew(centre - np.array([middle, 0, 0]))
        turn6 = np.kron(np.eye(2), self._to_tip)
        return np.asarray(
            turn6 @ spread @ np.vstack([arm, np.eye(3)]) @ self._to_tip.T * link.total_mass
        )
