"""Clearance of a bearing as delivered, after mounting with its fits, and at working temperature."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Annotated, Final, Literal, Self

import numpy as np

from lostmotion.laws.distributions import of_tolerance
from lostmotion.laws.fits import (
    CUSTOMARY_SHARE,
    STEEL_EXPANSION,
    ClearanceRange,
    Finish,
    clearance_range,
    effective_interference,
    interference_at,
    raceway_diameter,
    thermal_loss,
)
from lostmotion.parts.error_source import Expansion, LengthPlus, TemperatureDifference
from lostmotion.parts.provenance import Sourced
from lostmotion.units import Quantity, Toleranced

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

PlayOrPreload = Annotated[Toleranced, Quantity("m", "15 µm ± 8 µm", toleranced=True)]
Interference = Annotated[Toleranced, Quantity("m", "13 µm ± 11 µm", toleranced=True)]
FitShare = Annotated[float, Quantity("", "80 %", low=0, high=1)]

# For the mean and the deviation of a dimension that only counts above zero.
_QUANTILES: Final = 2000
# Stages of the clearance, in order.
STEPS: Final = ("delivered", "mounted", "working")


class MountedBearing(Sourced):
    """A bearing on its shaft and in its housing.

    bore, outside_diameter  of the bearing: the sizes of its seats
    clearance               radial internal clearance as delivered, diametral; ± over bearings. In a
                            file also a group of ISO 5753-1: "CN"
    shaft_interference      of the shaft in the inner ring, on the diameter; below zero loose. In a
                            file also by zone: shaft_fit = "k5"
    housing_interference    of the outer ring in its housing. In a file also by zone: housing_fit =
                            "H7"
    finish                  of the seats, "ground" or "turned": fitting flattens its roughness
    inner_share, outer_share  share of an interference that reduces the clearance
    inner_ring_warmer       temperature of the inner ring above that of the outer ring
    shaft_expansion, housing_expansion  thermal expansion, 1/K; default: that of the rings, which
                                        are of steel
    temperature_rise        of the whole unit above the temperature at which its fits are stated;
                            default: that of the arm
    """

    bore: LengthPlus
    outside_diameter: LengthPlus
    clearance: PlayOrPreload = Toleranced(0.0)
    shaft_interference: Interference = Toleranced(0.0)
    housing_interference: Interference = Toleranced(0.0)
    finish: Finish = "ground"
    inner_share: FitShare = CUSTOMARY_SHARE
    outer_share: FitShare = CUSTOMARY_SHARE
    inner_ring_warmer: TemperatureDifference = Toleranced(0.0)
    shaft_expansion: Expansion = STEEL_EXPANSION
    housing_expansion: Expansion = STEEL_EXPANSION
    temperature_rise: Annotated[float, Quantity("K", "15 K", low=-200, high=200)] | None = None

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, with the customary shares
        of an interference.
        """
        fits = {"inner_share": self.shaft_interference, "outer_share": self.housing_interference}
        default = {
            name: f"default, {CUSTOMARY_SHARE:.0%} of the interference".replace("%", " %")
            for name, fit in fits.items()
            if (fit.nominal or fit.tolerance) and name not in self.model_fields_set
        }
        return {**super().assumptions, **default}

    @property
    def elements(self) -> Literal["ball", "roller"]:
        """Return the kind of rolling element."""
        return "roller"

    @functools.cached_property
    def spreads(self) -> dict[str, ClearanceRange]:
        """Return the mean, deviation and limits of the clearance at each of `STEPS`."""
        shares = self.inner_share, self.outer_share
        delivered, *stated = (_limits_and_quantiles(each) for each in self._stated)
        (shaft, housing, _), (warm_shaft, warm_housing, lost) = (
            self._losses(*stated),
            self._losses(*self._warm(*stated)),
        )
        none = np.zeros_like(delivered)
        return {
            "delivered": clearance_range(delivered, none, none, none),
            "mounted": clearance_range(delivered, shaft, housing, none, *shares),
            "working": clearance_range(delivered, warm_shaft, warm_housing, lost, *shares),
        }

    @functools.cached_property
    def working(self) -> Toleranced:
        """Return the working clearance: mean and ± over bearings with the deviation of all
        dimensions, uniform where the delivered one is.
        """
        spread = self.spreads["working"]
        return Toleranced(
            spread.mean,
            spread.deviation * of_tolerance(self.clearance.law).bound,
            self.clearance.law,
        )

    def sample(self, count: int, seed: int) -> dict[str, Floats]:
        """Return clearances (bearing,), m, of `count` simulated bearings at each of `STEPS`, each
        dimension drawn from its own distribution.
        """
        rng = np.random.default_rng(seed)
        stated = []
        for each in self._stated:
            law = of_tolerance(each.law)
            uniform = rng.uniform(np.finfo(float).tiny, 1.0, count)
            stated.append(each.nominal + each.tolerance / law.bound * law.quantile(uniform))
        cold, warm = (
            self._losses(*stated[1:]),
            self._losses(*self._warm(stated[1], stated[2], stated[3])),
        )
        mounted, before_heating = (
            stated[0] - self.inner_share * shaft - self.outer_share * housing
            for shaft, housing, _ in (cold, warm)
        )
        return dict(zip(STEPS, (stated[0], mounted, before_heating - warm[2]), strict=True))

    @property
    def _stated(self) -> tuple[Toleranced, ...]:
        return (
            self.clearance,
            self.shaft_interference,
            self.housing_interference,
            self.inner_ring_warmer,
        )

    def warmed(self, rise: Toleranced | None) -> Self:
        """Return this bearing at the temperature rise of its arm, K; itself where it states its
        own, or where all is of steel.
        """
        if rise is None or not rise.nominal or not self._follows_temperature:
            return self
        return self.model_copy(update={"temperature_rise": rise.nominal})

    def clearance_per_kelvin(self, rise: Toleranced | None) -> float:
        """Return the change of the working clearance per kelvin within the ± of the temperature
        rise of its arm, m/K; zero without a ±.
        """
        if rise is None or not rise.tolerance or not self._follows_temperature:
            return 0.0
        hot, cold = (
            self.model_copy(
                update={"temperature_rise": rise.nominal + sign * rise.tolerance}
            ).working.nominal
            for sign in (1, -1)
        )
        return (hot - cold) / (2 * rise.tolerance)

    @property
    def _follows_temperature(self) -> bool:
        """Return whether its fits change with the temperature of its arm: not all is of steel, and
        it states no temperature of its own.
        """
        all_steel = self.shaft_expansion == self.housing_expansion == STEEL_EXPANSION
        return not all_steel and self.temperature_rise is None

    def _warm(
        self, shaft: Floats, housing: Floats, heating: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Return interferences and heating of the inner ring at the temperature rise of the
        unit.
        """
        rise = self.temperature_rise or 0.0
        inner = interference_at(shaft, rise, self.bore, inside=self.shaft_expansion)
        return (
            inner,
            interference_at(housing, rise, self.outside_diameter, outside=self.housing_expansion),
            heating,
        )

    def _losses(
        self, shaft: Floats, housing: Floats, heating: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Return the effective interferences and the loss of clearance to the temperature rise,
        m.
        """
        thermal = thermal_loss(
            heating, raceway_diameter(self.bore, self.outside_diameter, self.elements)
        )
        inner, outer = (
            effective_interference(tight, size, self.finish)
            for tight, size in ((shaft, self.bore), (housing, self.outside_diameter))
        )
        return inner, outer, thermal


def _limits_and_quantiles(dimension: Toleranced) -> Floats:
    """Return the lower and upper limit of a dimension, and its quantiles at the middles of equal
    shares of probability.
    """
    law = of_tolerance(dimension.law)
    share = np.concatenate(
        [[-1.0, 1.0], law.quantile((np.arange(_QUANTILES) + 0.5) / _QUANTILES) / law.bound]
    )
    return np.asarray(dimension.nominal + dimension.tolerance * share)
