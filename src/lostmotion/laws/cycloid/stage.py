"""Dimensions of a cycloidal stage, with the limits within which they form a smooth profile."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Literal, get_args

import numpy as np

Kind = Literal["ring pins", "lobe arcs", "lobe envelope", "planet pins"]
Part = Literal["planet", "ring"]
_KINDS: Final = get_args(Kind)
_FEWEST: Final = 3


@dataclass(frozen=True, slots=True)
class Stage:
    """A cycloidal stage.

    ring_radius   radius R of the pin circle, m
    pin_radius    radius Rr of the pins or lobes, m
    eccentricity  e, m
    pins          number N of pins
    kind          "ring pins": pins or rollers in the ring, z = N - 1 lobes on the disc. "lobe
                  arcs", "lobe envelope": integral lobes in the ring, of plain arcs or as the
                  envelope of the moving disc. "planet pins": hypocycloidal, N pins on the planet, z
                  = N + 1 lobes in the ring

    Raises ValueError with every reason why such a stage is impossible, and the nearest possible
    value.
    """

    ring_radius: float
    pin_radius: float
    eccentricity: float
    pins: int
    kind: Kind = "ring pins"

    def __post_init__(self) -> None:
        """Refuse an impossible stage, with all reasons at once."""
        wrong = list(_not_numbers(self)) or list(_impossible(self))
        if wrong:
            raise ValueError("this cycloidal stage cannot exist: " + "; ".join(wrong))

    @property
    def has_planet_pins(self) -> bool:
        """Return whether the pins are on the planet (hypocycloidal stage)."""
        return self.kind == "planet pins"

    @property
    def lobes(self) -> int:
        """Return the number of lobes of the toothed wheel: the disc, with planet pins the ring."""
        return self.pins + 1 if self.has_planet_pins else self.pins - 1

    @property
    def shortening(self) -> float:
        """Return K1 = e N/R, the shortening ratio of the trochoid."""
        return self.eccentricity * self.pins / self.ring_radius

    @property
    def planet_pitch_radius(self) -> float:
        """Return the distance (m) of the pitch point from the planet's centre: e z, with planet
        pins e N. It is also the largest contact arm.
        """
        return self.eccentricity * (self.pins if self.has_planet_pins else self.lobes)

    @property
    def ring_pitch_radius(self) -> float:
        """Return the distance (m) of the pitch point from the ring's centre: e N, with planet pins
        e z.
        """
        return self.planet_pitch_radius + self.eccentricity

    @property
    def tip_radius(self) -> float:
        """Return the outer radius (m) of the planet: R - Rr + e for a disc, R + Rr for planet
        pins.
        """
        return (
            self.ring_radius + self.pin_radius
            if self.has_planet_pins
            else self.ring_radius - self.pin_radius + self.eccentricity
        )

    @property
    def _m(self) -> int:
        # The locus is R exp(it) -+ e exp(imt). Formulas for planet pins are those of the disc with
        # -N for N.
        return -self.pins if self.has_planet_pins else self.pins


@dataclass(frozen=True, slots=True)
class Modification:
    """Profile modification of the toothed wheel. Positive values remove material.

    roller  dRr, m: a larger generating roller
    circle  dR, m: a smaller generating pin circle (with planet pins a larger one); negative for the
            opposite
    turn    dpsi, rad: both flanks of a tooth rotated about the wheel's centre towards the middle of
            the tooth
    """

    roller: float = 0.0
    circle: float = 0.0
    turn: float = 0.0


def _not_numbers(stage: Stage) -> list[str]:
    wrong = [
        f"the {name} is {value!r} m, but must be a positive length"
        for name, value in (
            ("pin circle radius", stage.ring_radius),
            ("pin radius", stage.pin_radius),
            ("eccentricity", stage.eccentricity),
        )
        if not (math.isfinite(value) and value > 0)
    ]
    if stage.pins != int(stage.pins) or stage.pins < _FEWEST:
        wrong.append(f"it has {stage.pins} pins, but needs a whole number of {_FEWEST} or more")
    if stage.kind not in _KINDS:
        wrong.append(
            f"its kind is {stage.kind!r}, but must be one of {', '.join(map(repr, _KINDS))}"
        )
    return wrong


def _mm(length: float, digits: int = 4) -> str:
    """Return a limit in mm, rounded down so that it is still possible."""
    return f"{math.floor(length * 1e3 * 10**digits) / 10**digits:.{digits}f} mm"


def _impossible(stage: Stage) -> list[str]:
    wrong = []
    k1 = stage.shortening
    if k1 >= 1:
        limit = stage.ring_radius / stage.pins
        wrong.append(
            f"the profile loops because K1 = e N/R is {k1:.4f}, not below 1: the eccentricity "
            f"must stay below {_mm(limit)}, "
            f"or the pin circle radius above {stage.eccentricity * stage.pins * 1e3:.4f} mm"
        )
    folded = 1 - 2 / stage.pins  # (z - 1)/(z + 1)
    if stage.kind == "lobe envelope" and folded <= k1 < 1:
        limit = stage.ring_radius * folded / stage.pins
        wrong.append(
            f"the second branch of the envelope folds because K1 = e N/R is {k1:.4f}, not "
            f"below (z - 1)/(z + 1) = {folded:.4f}: the eccentricity "
            f"must stay below {_mm(limit)}"
        )
    neighbours = stage.ring_radius * math.sin(math.pi / stage.pins)
    undercut = (
        math.inf
        if k1 >= 1
        else undercut_limit(
            stage.ring_radius, stage.eccentricity, stage.pins, planet_pins=stage.has_planet_pins
        )
    )
    if stage.pin_radius >= undercut:
        wrong.append(
            f"a pin radius of {stage.pin_radius * 1e3:.4f} mm undercuts the flank: the largest "
            f"possible is {_mm(min(undercut, neighbours))}"
        )
    if stage.pin_radius >= neighbours:
        wrong.append(
            "neighbouring pins overlap: the largest possible pin radius is "
            f"{_mm(min(undercut, neighbours))}"
        )
    return wrong


def undercut_limit(
    ring_radius: float, eccentricity: float, pins: int, *, planet_pins: bool = False
) -> float:
    """Return the largest pin radius (m) without undercut: the smallest radius of curvature of the
    locus on the side of the flank.

    ring_radius and eccentricity (m). Valid for K1 < 1. Closed form: with K1 > (N-2)/(2N-1) it is R
    sqrt(27 (1-K1^2)(N-1))/(N+1)^1.5, else R (1+K1)^2/(N K1 + 1); planet pins with -N for N.
    """
    k1, m = eccentricity * pins / ring_radius, -pins if planet_pins else pins
    a, b, c = 1 + m * k1**2, (m + 1) * k1, 1 + k1**2
    stationary = 3 * a / b - c / k1
    cosines = np.array([-1.0, 1.0] + ([stationary] if abs(stationary) < 1 else []))
    narrowing = (
        (-1 if planet_pins else 1)
        * (a - b * cosines)
        / (ring_radius * (c - 2 * k1 * cosines) ** 1.5)
    )
    sharpest = float(narrowing.max())
    return 1 / sharpest if sharpest > 0 else math.inf
