"""Units by name, and the factor from each to SI."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    import pint

# pint's own table calls the radian dimensionless and takes 0.3 s to load; this one does neither.
_DEFINITIONS: Final = """
nano- = 1e-9 = n-
micro- = 1e-6 = µ- = μ- = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
meter = [length] = m = metre
gram = [mass] = g
second = [time] = s
minute = 60 * second = min
hour = 3600 * second = h
kelvin = [temperature] = K
radian = [angle] = rad
degree = 0.017453292519943295 * radian = deg = °
arcminute = degree / 60 = arcmin
arcsecond = degree / 3600 = arcsec
turn = 360 * degree = rev
inch = 0.0254 * meter = in
foot = 12 * inch = ft
pound = 0.45359237 * kilogram = lb
newton = kilogram * meter / second**2 = N
newton_meter = newton * meter = Nm
pound_force = 4.4482216152605 * newton = lbf
pascal = newton / meter**2 = Pa
percent = 0.01 = pct
"""


class UnitError(ValueError):
    """A text is no quantity of the wanted dimension; the message says why."""


@functools.cache
def _registry() -> pint.UnitRegistry[float]:
    import pint

    registry: pint.UnitRegistry[float] = pint.UnitRegistry(None)
    registry.load_definitions(_DEFINITIONS.splitlines())
    return registry


# The units of most files, with their SI unit and size: pint itself takes 0.3 s to load.
_COMMON: Final = {
    "": ("", 1.0),
    "%": ("", 0.01),
    "µm/m": ("", 1e-6),
    "m": ("m", 1.0),
    "mm": ("m", 1e-3),
    "µm": ("m", 1e-6),
    "rad": ("rad", 1.0),
    "mrad": ("rad", 1e-3),
    "deg": ("rad", 0.017453292519943295),
    "arcmin": ("rad", 0.0002908882086657216),
    "arcsec": ("rad", 4.84813681109536e-06),
    "kg": ("kg", 1.0),
    "g": ("kg", 1e-3),
    "kg m^2": ("kg m^2", 1.0),
    "kg cm^2": ("kg m^2", 1e-4),
    "s": ("s", 1.0),
    "min": ("s", 60.0),
    "h": ("s", 3600.0),
    "N": ("N", 1.0),
    "kN": ("N", 1e3),
    "N m": ("N m", 1.0),
    "N m/rad": ("N m/rad", 1.0),
    "N m/deg": ("N m/rad", 57.29577951308232),
    "N m/arcmin": ("N m/rad", 3437.746770784939),
    "N/m": ("N/m", 1.0),
    "N/µm": ("N/m", 1e6),
    "MN/m^3": ("N/m^3", 1e6),
    "MPa": ("Pa", 1e6),
    "GPa": ("Pa", 1e9),
    "K": ("K", 1.0),
    "1/K": ("1/K", 1.0),
    "kg/m^3": ("kg/m^3", 1.0),
}
_COMMON_SI: Final = {si for si, _ in _COMMON.values()}
# The SI unit of a temperature above absolute zero; "K" alone is that of a difference.
ABSOLUTE: Final = "K above absolute zero"
ZERO_CELSIUS: Final = 273.15
_FAHRENHEIT: Final = (5 / 9, 459.67 * 5 / 9)
# Size in kelvins and zero point, K, of the scales of temperature.
_SCALES: Final = {
    "K": (1.0, 0.0),
    **dict.fromkeys(("°C", "degC"), (1.0, ZERO_CELSIUS)),
    **dict.fromkeys(("°F", "degF"), _FAHRENHEIT),
}


def zero_point(unit: str, si: str) -> float:
    """Return the zero of `unit` in `si` units: not zero for a scale of temperature only. Raises
    UnitError as `factor`.
    """
    return _scale(unit)[1] if si == ABSOLUTE else 0.0


def _scale(unit: str) -> tuple[float, float]:
    if unit not in _SCALES:
        problem = f"'{unit}' is not a unit of" if unit else "without a unit of"
        raise UnitError(f"{problem} {_UNITS_IN_WORDS[ABSOLUTE]}")
    return _SCALES[unit]


@functools.lru_cache(maxsize=1024)
def factor(unit: str, si: str) -> float:
    """Return how many `si` units one `unit` is. Raises UnitError for another dimension or an
    unknown word.
    """
    if si == ABSOLUTE:
        return _scale(unit)[0]
    own, size = _COMMON.get(unit, (None, 1.0))
    wanted = "" if si == "1" else si
    if own == wanted:
        return size
    problem = f"'{unit}' is not a unit of" if unit else "without a unit of"
    other = UnitError(f"{problem} {_UNITS_IN_WORDS.get(si, si)}")
    if (own is not None and wanted in _COMMON_SI) or unit in _SCALES:
        raise other
    import pint

    plain = unit.strip().replace("%", "pct").replace("″", "arcsec").replace('"', "arcsec")
    plain = plain.replace("′", "arcmin").replace("'", "arcmin").replace("·", "*")
    registry = _registry()
    try:
        return float(
            registry.Quantity(1.0, registry.parse_units(plain))
            .to(registry.parse_units(si))
            .magnitude
        )
    except pint.DimensionalityError:
        raise other from None
    except (
        pint.UndefinedUnitError,
        pint.DefinitionSyntaxError,
        ValueError,
        TypeError,
        AttributeError,
        KeyError,
    ):
        # "m^0" is a KeyError to pint
        raise UnitError(f"'{unit}' is not a known unit") from None


_UNITS_IN_WORDS: Final = {
    "": "a plain number",
    "m": "length (mm, µm, m, in)",
    "m^2": "area (mm^2)",
    "m^4": "second moment of area (mm^4)",
    "rad": "angle (arcmin, arcsec, deg, mrad)",
    "kg": "mass (kg, g)",
    "kg m^2": "moment of inertia (kg m^2, kg cm^2)",
    "s": "time (s, min, h)",
    "N": "force (N, kN)",
    "N m": "torque (N m)",
    "N m/rad": "angular stiffness (N m/arcmin, N m/rad)",
    "N/m": "linear stiffness (N/µm, N/m)",
    "N/m^3": "pressure per settlement (MN/m^3)",
    "Pa": "pressure (GPa, MPa)",
    "K": "temperature difference (K)",
    ABSOLUTE: "temperature (°C, K)",
    "1/K": "thermal expansion (1/K, µm/m/K)",
    "kg/m^3": "density (kg/m^3)",
    "m/s^2": "acceleration (m/s^2)",
}


def unit_in_words(si: str) -> str:
    """Return the dimension of an SI unit in users' words, with examples."""
    return _UNITS_IN_WORDS.get(si, si)
