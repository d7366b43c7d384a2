"""Working clearance of a bearing, from its clearance as delivered, its fits and its temperature.

Clearances are radial internal clearances as defined by the standards: the full free travel across
the bearing, on the diameter. Interference is on the diameter too. A negative clearance is preload.
Sources: ISO 5753-1 (clearance), ISO 286 (fits); shares and smoothing from bearing makers'
handbooks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

Finish = Literal["ground", "turned"]
Limits = tuple[float, float]

# Interference that remains after the surface peaks are flattened: d/(d + 2 mm) of it on a ground
# seat, d/(d + 3 mm) on a turned one.
_PEAKS: Final[dict[Finish, float]] = {"ground": 2e-3, "turned": 3e-3}
# Thermal expansion of bearing steel, shafts and housings of steel, 1/K.
STEEL_EXPANSION: Final = 12.5e-6
# Customary share of the effective interference by which a raceway grows or shrinks.
CUSTOMARY_SHARE: Final = 0.8


def interference(inside: Limits, outside: Limits) -> Limits:
    """Return the lower and upper limit (m) of the interference of a body in a bore, from their
    limit deviations (m, lower and upper).

    `inside`: deviations of the shaft or the outer ring; `outside`: of the inner ring or the
    housing. Negative for a loose fit.
    """
    return inside[0] - outside[1], inside[1] - outside[0]


def effective_interference(
    measured: Floats | float, diameter: Floats | float, finish: Finish = "ground"
) -> Floats:
    """Return the part of a measured interference (m, any shape) that remains after the surface
    peaks are flattened; zero for a loose fit.

    It is the measured interference times d/(d + 2 mm) for a ground seat, or d/(d + 3 mm) for a
    turned one, with the `diameter` d (m) of the seat. Valid for seats of about 10 to 500 mm. Raises
    ValueError for a diameter of zero or less, KeyError for another finish.
    """
    size = np.asarray(diameter, dtype=float)
    if (size <= 0).any():
        raise ValueError("the diameter of a seat must be above zero")
    return np.asarray(np.maximum(measured, 0.0) * size / (size + _PEAKS[finish]))


def interference_at(
    stated: Floats | float,
    rise: Floats | float,
    diameter: float,
    inside: float = STEEL_EXPANSION,
    outside: float = STEEL_EXPANSION,
) -> Floats:
    """Return an interference (m) at a temperature `rise` (K) of both bodies above that at which it
    is stated: stated + (a_i - a_o) d dT.

    diameter (m) of the seat; inside, outside: thermal expansion (1/K) of the body in the bore and
    of that around it. Arrays are of shapes that broadcast. Valid for uniform temperature of each
    body.
    """
    return np.asarray(stated + (inside - outside) * diameter * np.asarray(rise))


def mounted_clearance(
    initial: Floats | float,
    inner: Floats | float,
    outer: Floats | float = 0.0,
    inner_share: float = CUSTOMARY_SHARE,
    outer_share: float = CUSTOMARY_SHARE,
) -> Floats:
    """Return the clearance (m) of the bearing mounted on its shaft and in its housing: initial -
    f_i I_i - f_o I_o.

    initial                   clearance as delivered, m
    inner, outer              effective interference of each ring, m; negative for a loose fit,
                              which counts as zero
    inner_share, outer_share  f_i, f_o: change of the raceway's diameter over the interference, 0.7
                              to 0.9, customarily 0.8

    Arrays are of shapes that broadcast. For thick rings the shares follow from Lamé's equations.
    Raises ValueError for a share outside 0..1.
    """
    if not (0 <= inner_share <= 1 and 0 <= outer_share <= 1):
        raise ValueError("the share of the interference must be between 0 and 1")
    return np.asarray(
        initial - inner_share * np.maximum(inner, 0.0) - outer_share * np.maximum(outer, 0.0)
    )


def raceway_diameter(bore: float, outside: float, kind: Literal["ball", "roller"]) -> float:
    """Return an outer raceway's diameter (m) for its thermal growth: (4D + d)/5 for a ball bearing,
    (3D + d)/4 for a roller bearing.

    For bearings of the usual dimension series, not for thin-section ones. Raises ValueError unless
    0 < bore < outside.
    """
    if not 0 < bore < outside:
        raise ValueError(
            "a bearing's bore must be above zero and smaller than its outside diameter"
        )
    return (4 * outside + bore) / 5 if kind == "ball" else (3 * outside + bore) / 4


def thermal_loss(
    temperature_difference: Floats | float, raceway: float, expansion: float = STEEL_EXPANSION
) -> Floats:
    """Return the loss of clearance (m) for a temperature difference of the inner above the outer
    ring in K (any shape): expansion x dT x De.

    `raceway` De (m) is the raceway diameter of the outer ring. A difference of 5-10 K is normal, of
    15-20 K usual at high speed; in a robot joint that moves intermittently it is near zero. With a
    hotter outer ring the difference is negative, and the clearance grows.
    """
    return np.asarray(expansion * np.asarray(temperature_difference) * raceway)


def working_clearance(mounted: Floats | float, thermal: Floats | float = 0.0) -> Floats:
    """Return the clearance (m) of a mounted bearing at its working temperature, without load;
    negative for preload.

    Loads deform the contacts: see `rolling`.
    """
    return np.asarray(np.asarray(mounted) - thermal)


@dataclass(frozen=True, slots=True)
class ClearanceRange:
    """Clearance of a series of bearings, m: mean and standard deviation over bearings, and
    worst-case limits (`clearance_range`).
    """

    mean: float
    deviation: float
    lowest: float
    highest: float


def clearance_range(
    initial: Floats,
    inner: Floats,
    outer: Floats,
    thermal: Floats,
    inner_share: float = CUSTOMARY_SHARE,
    outer_share: float = CUSTOMARY_SHARE,
) -> ClearanceRange:
    """Return mean, deviation and limits (m) of the working clearance of bearings whose dimensions
    are independent of each other.

    initial, inner, outer, thermal  (quantile + 2,) m: delivered clearance, effective interferences
                                    and thermal loss; first the lower and the upper limit of each,
                                    then its quantiles at the middles of equal shares of probability

    A loose fit takes nothing away, however loose, so that the mean lies above the middle of the
    limits where a fit may be loose or tight. With 2 000 quantiles the mean is within 1e-6 of the
    largest tolerance, the deviation within 2e-5 of itself. Errors as `mounted_clearance`.
    """
    none = np.zeros(1)
    parts = (
        initial,
        mounted_clearance(none, inner, none, inner_share, outer_share),
        mounted_clearance(none, none, outer, inner_share, outer_share),
        working_clearance(none, thermal),
    )
    mean, variance = (sum(float(way(each[2:])) for each in parts) for way in (np.mean, np.var))
    lowest, highest = (sum(float(way(each[:2])) for each in parts) for way in (np.min, np.max))
    return ClearanceRange(mean, float(np.sqrt(variance)), lowest, highest)
