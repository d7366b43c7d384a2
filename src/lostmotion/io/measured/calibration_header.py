"""What the comments above a file of measurements state, one per line.

    # instrument: dial
    # noise: 20 µm
    # deviations: turn 0.2 mrad, shift 0.1 mm
    # payload: 2 kg
    # temperature: 23 °C
    # camera: fx 800, fy 800, cx 320, cy 240
    # tag size: 40 mm

`deviations` are those assumed for errors that the arm's file does not state, by the names of
`Deviations`. Payload and temperature are compared with those of the arm's file. Other comments are
free, but for keys that are nearly one of these. Capitals do not count, and `=` is as good as `:`.
"""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, Final, cast, get_args

from pydantic_core import PydanticCustomError

from lostmotion.calibration.instruments import Camera
from lostmotion.calibration.terms import Deviations
from lostmotion.errors import Problem, nearest, shown
from lostmotion.io.limits import listed
from lostmotion.io.measured.instrument import Instrument
from lostmotion.unit_registry import ABSOLUTE, ZERO_CELSIUS
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm

_KEYS: Final = (
    *("instrument", "noise", "deviations", "payload", "temperature", "camera", "tag size"),
    "sign",  # which `stated_sign` reads
)
# A key with what it states: after a colon or an equals sign, or a number at once.
_LINE: Final = re.compile(
    rf"^\s*#\s*({'|'.join(_KEYS[:-1])})(?:\s*[:=]\s*|\s+(?=[-+.]?\d))(.*)$", re.IGNORECASE
)
_OTHER: Final = re.compile(r"^\s*#\s*([a-z][\w -]{1,20}?)\s*[:=]", re.IGNORECASE)
# Likeness from which the key of a comment is a misspelt one.
_MISSPELT: Final = 0.8
_FOCAL: Final = Quantity("", "800", low=1, high=1e6)
_CENTRE: Final = Quantity("", "320", above=0, high=1e6)
_CAMERA: Final = {"fx": _FOCAL, "fy": _FOCAL, "cx": _CENTRE, "cy": _CENTRE}
_TURN: Final = Quantity("rad", "0.2 mrad", above=0, high=1)
_SHIFT: Final = Quantity("m", "0.1 mm", above=0, high=10)
_SIZES: Final = {
    field.name: _SHIFT if "shift" in field.name else _TURN
    for field in fields(Deviations)
    if field.name not in {"orders", "compliance"}
}
_ALONE: Final = {
    "noise": Quantity("m", "20 µm", low=1e-9, high=1),
    "payload": Quantity("kg", "2 kg", low=0, high=1e6),
    "temperature": Quantity(ABSOLUTE, "23 °C", low=ZERO_CELSIUS - 100, high=ZERO_CELSIUS + 200),
    "tag size": Quantity("m", "40 mm", low=1e-4, high=10),
}
# A payload and a temperature that differ by more than these are not the file's, kg and K.
_SAME: Final = {"payload": 0.05, "temperature": 3.0}


@dataclass(frozen=True)
class StatedInFile:
    """What the comments of a file state; None where they do not.

    noise    standard deviation of a coordinate, m
    payload  mass at the tool, kg
    sizes    deviations of errors that the arm's file does not state, rad and m
    """

    instrument: str | None = None
    noise: float | None = None
    sizes: Deviations | None = None
    remarks: tuple[str, ...] = ()
    camera: Camera | None = None
    payload: float | None = None


def read_header(file: str, text: str, arm: Arm) -> tuple[StatedInFile, list[Problem]]:
    """Return what the comments of a file state, and the mistakes in them."""
    stated: dict[str, str] = {}
    mistakes: list[Problem] = []
    found: dict[str, float] = {}
    for number, line in enumerate(text.splitlines(), 1):
        match = _LINE.match(line)
        if match is None:
            mistakes += _misspelt(file, number, line)
            continue
        key, value = match[1].lower(), match[2].strip()
        if stated.setdefault(key, value) != value:
            expected = f"{shown(stated[key])}, as stated above it, or one line"
            mistakes.append(Problem(file, f"line {number}, {key}", shown(value), expected))
        wanted = _ALONE
        pairs = [(key, value)] if key in wanted else []
        if key in {"deviations", "camera"}:
            wanted = _SIZES if key == "deviations" else _CAMERA
            parts = [part.strip().replace("=", " ").partition(" ") for part in value.split(",")]
            pairs = [(name, size.strip()) for name, _, size in parts]
        if key == "instrument" and value not in get_args(Instrument):
            known = list(get_args(Instrument))
            mistakes.append(_mistake(file, number, value, known, "instrument: dial"))
        for name, size in pairs:
            if name not in wanted:
                example = "camera: fx 800, fy 800, cx 320, cy 240"
                if key == "deviations":
                    example = "deviations: turn 0.2 mrad, shift 0.1 mm"
                mistakes.append(_mistake(file, number, name, list(wanted), example))
                continue
            quantity = wanted[name]
            try:
                found[name] = cast("float", quantity(size.removesuffix("px")))
            except PydanticCustomError as error:
                why = f"{shown(size)}: {(error.context or {})['why']}"
                example = f"# {key}: {'' if name == key else f'{name} '}{quantity.example}"
                where = f"line {number}, {name}"
                mistakes.append(Problem(file, where, why, quantity.expected, example))
    sizes: dict[str, Any] = {name: size for name, size in found.items() if name in _SIZES}
    return (
        StatedInFile(
            stated.get("instrument"),
            found.get("noise"),
            replace(Deviations(), **sizes) if sizes else None,
            tuple(_compared(found, arm)),
            _camera(found),
            found.get("payload"),
        ),
        mistakes,
    )


def _misspelt(file: str, number: int, line: str) -> list[Problem]:
    """Return the mistake of a comment whose key is nearly one that states something."""
    match = _OTHER.match(line)
    key = match[1].lower() if match else ""
    near = difflib.get_close_matches(key, _KEYS, n=1, cutoff=_MISSPELT)
    if not near or key == near[0]:
        return []
    expected = f"# {near[0]}: and a value, or a comment in other words"
    return [Problem(file, f"line {number}", shown(key), expected, "", near[0])]


def _camera(values: dict[str, float]) -> Camera | None:
    """Return the camera where all of it is stated."""
    keys = (*_CAMERA, "tag size")
    return Camera(*(values[key] for key in keys)) if set(keys) <= set(values) else None


def _mistake(file: str, line: int, found: str, known: list[str], example: str) -> Problem:
    expected = listed(known)
    return Problem(
        file, f"line {line}", shown(found), expected, f"# {example}", nearest(found, known)
    )


def _compared(values: dict[str, float], arm: Arm) -> list[str]:
    """Return remarks on a payload and a temperature that are not those of the arm's file."""
    rise, temperature = arm.environment.rise, None
    if rise is not None:
        temperature = arm.environment.reference_temperature + rise.nominal
    known = {"payload": (arm.payload.mass, "kg", 0.0), "temperature": (temperature, "°C", 273.15)}
    out = []
    for name, (here, unit, zero) in known.items():
        if name not in values:
            continue
        there = values[name] - zero
        if here is None:
            out.append(f"measured at {there:.4g} {unit}; the arm file states no {name}")
        elif abs(values[name] - here) > _SAME[name]:
            own = f"{here - zero:.4g} {unit}"
            out.append(f"measured with a {name} of {there:.4g} {unit}; the arm file has {own}")
    return out
