"""Modulus of polymers under load over time, and at a temperature, over that of a short test at 23
°C.
"""

from __future__ import annotations

import math
from typing import Final

HOUR: Final = 3600.0
# Duration (s) of the load in a short test.
SHORT: Final = 60.0
# Temperature (K above absolute zero) at which moduli are stated.
REFERENCE: Final = 296.15
_LONG: Final = 1000 * HOUR
# Share of the modulus that is left at the heat deflection temperature.
_AT_DEFLECTION: Final = 0.5
_LEAST: Final = 0.05


def creep_factor(duration: float, after_an_hour: float, after_1000_hours: float) -> float:
    """Return the creep modulus over the modulus of a short test, for a load that lasts for
    `duration` (s).

    Linear in the logarithm of time between a minute (1), an hour and 1 000 hours, where it is
    stated (ISO 899-1), and on the last line beyond; not below 0.05. An interpolation between data,
    typically within 3 % of creep curves of glassy polymers up to 10 000 hours [M 75].
    """
    if duration <= SHORT:
        return 1.0
    if duration <= HOUR:
        return 1.0 + (after_an_hour - 1.0) * math.log(duration / SHORT) / math.log(HOUR / SHORT)
    return max(
        after_an_hour
        + (after_1000_hours - after_an_hour) * math.log(duration / HOUR) / math.log(_LONG / HOUR),
        _LEAST,
    )


def temperature_factor(temperature: float, deflection: float) -> float:
    """Return the modulus at a temperature over that at 23 °C, both in K above absolute zero: linear
    from 1 to 0.5 at the heat deflection temperature.

    `deflection` is that of ISO 75 at 0.45 MPa. A rule of thumb for printed thermoplastics [M 75]; 1
    below 23 °C. Raises ValueError above the heat deflection temperature, where a part does not keep
    its shape.
    """
    if temperature > deflection:
        raise ValueError("a temperature above the heat deflection temperature")
    return 1.0 - (1.0 - _AT_DEFLECTION) * max(temperature - REFERENCE, 0.0) / (
        deflection - REFERENCE
    )
