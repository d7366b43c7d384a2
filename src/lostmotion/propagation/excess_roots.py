"""Factors at which an excess over a target is zero: the root with its interval, and the ranges of
factors that meet the target.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.intervals import Estimate
from lostmotion.errors import DidNotConvergeError

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.spatial import Floats

# Relative tolerance of a root, and relative step for the slope there.
_CLOSE: Final = 1e-7
_STEP: Final = 0.02
# Tolerance of the ends of an interval, relative to its half width.
_END: Final = 1e-2


@dataclass(frozen=True, slots=True)
class Excess:
    """Excess over a target, positive where it is not met: value and half width of its 95 %
    interval; NaN where the sample is too small.
    """

    value: float
    half: float


def root(excess: Callable[[float], Excess], low: float, high: float) -> float:
    """Return where between `low` and `high` the excess is zero; raises DidNotConvergeError where
    both have the same sign.
    """
    from scipy.optimize import brentq

    try:
        return float(
            brentq(
                lambda x: excess(x).value,
                low,
                high,
                xtol=_CLOSE * max(abs(low), abs(high)),
                rtol=_CLOSE,
            )
        )
    except ValueError as error:
        raise DidNotConvergeError(
            f"no change of sign between {low:g} and {high:g}: {error}"
        ) from error


def root_interval(excess: Callable[[float], Excess], at: float) -> Estimate:
    """Return a root with its 95 % interval, whose ends are where the excess equals the half width
    of its own interval.

    The interval is inverted because the slope may change within it (R. Woodruff, J. Am. Stat.
    Assoc. 47 (1952) 635, for quantiles). A negative end is set to zero; an end beyond sixteen times
    its first guess is NaN.
    """
    step = _STEP * at
    slope = (excess(at + step).value - excess(at - step).value) / (2 * step) if step else 0.0
    half = excess(at).half
    if not half > 0 or not slope:
        return Estimate(at, at if half == 0 else math.nan, at if half == 0 else math.nan)
    sign = math.copysign(1.0, slope)

    def beyond(x: float, side: float) -> float:
        here = excess(x)
        return side * sign * here.value - here.half

    return Estimate(
        at,
        _end(lambda x: beyond(x, -1.0), at, -half / abs(slope)),
        _end(lambda x: beyond(x, 1.0), at, half / abs(slope)),
    )


def _end(beyond: Callable[[float], float], at: float, step: float) -> float:
    """Return the end of the interval in the direction of `step` from the root; zero where it would
    be negative, NaN where there is none.
    """
    from scipy.optimize import brentq

    for k in range(5):
        far = max(at + 2.0**k * step, 0.0)
        if beyond(far) > 0:
            return float(brentq(beyond, at, far, xtol=_END * abs(step), rtol=_CLOSE))
        if far == 0:
            return 0.0
    return math.nan


def ranges_within(
    excess: Callable[[float], Excess], tried: Floats, *, refine: bool
) -> tuple[tuple[float, float], ...]:
    """Return the ranges of factors that meet the target among those tried, and with `refine`
    between them; the last may extend to infinity.
    """
    at = sorted({*(float(each) for each in tried), 1.0})
    values = [excess(each).value for each in at]
    if refine and min(values) > 0:
        at, values = _with_least(excess, at, values)
    out: list[list[float]] = []
    for k, here in enumerate(at):
        before = k > 0 and values[k - 1] <= 0
        if values[k] <= 0 and not before:
            out.append([0.0 if k == 0 else root(excess, at[k - 1], here), math.inf])
        elif values[k] > 0 and before:
            out[-1][1] = root(excess, at[k - 1], here)
    return tuple((low, high) for low, high in out)


def _with_least(
    excess: Callable[[float], Excess], at: list[float], values: list[float]
) -> tuple[list[float], list[float]]:
    """Add the factor with the least excess."""
    from scipy.optimize import minimize_scalar

    k = int(np.argmin(values))
    low, high = at[max(k - 1, 0)], at[min(k + 1, len(at) - 1)]
    best = float(
        minimize_scalar(
            lambda factor: excess(factor).value,
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-4 * high},
        ).x
    )
    both = sorted([*zip(at, values, strict=True), (best, excess(best).value)])
    return [one for one, _ in both], [other for _, other in both]


def nearest_end(ranges: tuple[tuple[float, float], ...]) -> float:
    """Return the upper end of the range that contains 1, else the end nearest to 1."""
    for low, high in ranges:
        if low <= 1 <= high:
            return high
    return min((end for both in ranges for end in both), key=lambda end: abs(end - 1))
