"""What went into a result: every value of an arm or a part in the unit that people read, with its
state and its source.
"""

from __future__ import annotations

import re
from itertools import groupby
from typing import TYPE_CHECKING, Any, Final, get_args

from lostmotion.band import Band
from lostmotion.error_model.provenance import KINDS
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.parts.provenance import DEFAULT_SCATTER
from lostmotion.printed import stated_text
from lostmotion.reporting.sheet import Row, Section, in_words, several
from lostmotion.unit_registry import ABSOLUTE, ZERO_CELSIUS
from lostmotion.units import Quantity, Toleranced

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from lostmotion.error_model.given_values import GivenValue
    from lostmotion.error_model.provenance import States
    from lostmotion.parts.error_source import Part

# Units by that of SI, the largest first: name, its size in SI, and the smallest value that is
# written in it.
_UNITS: Final[dict[str, tuple[tuple[str, float, float], ...]]] = {
    "m": (("m", 1.0, 1.0), ("mm", 1e-3, 1e-4), ("µm", 1e-6, 0.0)),
    "m^2": (("mm²", 1e-6, 0.0),),
    "m^4": (("mm⁴", 1e-12, 0.0),),
    "rad": (
        ("°", 0.017453292519943295, 0.0174),
        ("arcmin", 2.908882086657216e-4, 2.9e-5),
        ("arcsec", 4.84813681109536e-6, 0.0),
    ),
    "kg m^2": (("kg m²", 1.0, 0.1), ("kg cm²", 1e-4, 0.0)),
    "kg/m^3": (("kg/m³", 1.0, 0.0),),
    "m/s^2": (("m/s²", 1.0, 0.0),),
    "N/m": (("N/µm", 1e6, 1e5), ("N/mm", 1e3, 0.0)),
    "N m/rad": (("N m/arcmin", 3437.746770784939, 0.0),),
    "N/m^3": (("MN/m³", 1e6, 0.0),),
    "N": (("kN", 1e3, 1e4), ("N", 1.0, 0.0)),
    "Pa": (("GPa", 1e9, 1e9), ("MPa", 1e6, 0.0)),
    "1/K": (("µm/(m K)", 1e-6, 0.0),),
    "s": (("h", 3600.0, 3600.0), ("s", 1.0, 0.0)),
}
_SHARED: Final = (
    "a part that several joints share is listed once, by its name in the file; equal parts of "
    "their own under the first of them"
)
# Units of estimates, and how many of them are listed.
_OF_ESTIMATE: Final = {"rad": Quantity("rad", "1 mrad"), "m": Quantity("m", "1 mm")}
_MOST_ESTIMATES: Final = 60
# Numbers of a list that are written out.
_WRITTEN_OUT: Final = 6


def inputs_section(given: Sequence[GivenValue], known: States | None = None) -> tuple[Section, ...]:
    """Return the table of what went in, those values of a part together that have one state and one
    source; no table without any value.

    With `known`, what nothing describes follows: those kinds of error are ideal.
    """
    together = groupby(given, lambda each: (each.owner, each.state, each.source))
    rows = [
        Row(
            short_name(owner), (in_words("; ".join(map(_written, values))), in_words(state)), source
        )
        for (owner, state, source), values in together
    ]
    ideal = _ideal_rows(known) if known is not None else []
    if not (rows or ideal):
        return ()
    if known is not None:
        rows += _estimates(known)
    assumed = sum(bool(each.reason) and each.reason != DEFAULT_SCATTER for each in given)
    counted = [
        f"{several(sum(each.state == 'stated' for each in given), 'value')} stated",
        f"{assumed} assumed",
    ]
    counted += [f"{several(len(ideal), 'kind')} of error ideal"] if ideal else []
    folded = f"{', '.join(counted)}: each with its source"
    return (
        Section(
            "inputs",
            "What went in",
            ("values", "state"),
            (*rows, *ideal),
            _SHARED if known is not None else "",
            folded,
        ),
    )


def _estimates(known: States) -> list[Row]:
    """Return the estimates of a robot: those of a measurement in one line, those that are stated in
    one each.
    """
    if known.estimates and (source := known.estimates[0].source):
        text = in_words(several(len(known.estimates), "estimate"))
        return [Row("calibration", (text, in_words("estimated")), f"from {source}")]
    rows = []
    for each in known.estimates[:_MOST_ESTIMATES]:
        if each.unit in _OF_ESTIMATE:
            unit = _OF_ESTIMATE[each.unit]
            size = f"{value_text(each.value, unit)} ± {value_text(each.deviation, unit)}"
        else:
            size = f"{stated_text(each.value)} ± {stated_text(each.deviation)} standard deviations"
        note = "" if each.in_file else "an error that the arm file does not state"
        if each.assumed:
            note += ": a number of standard deviations of the usual size, which is assumed"
        state = in_words("assumed" if each.assumed else "stated")
        rows.append(Row(short_name(each.name), (in_words(size), state), note))
    return rows


def _ideal_rows(known: States) -> list[Row]:
    """Return a line for each kind of error that some or all joints do not describe, and for what is
    not described of the base.
    """
    out = []
    for kind in KINDS:
        having = [each for each in known.joints if kind in each.states]
        ideal = [each.joint for each in having if each.states[kind] == "ideal"]
        if kind != "lumped" and ideal:
            where = "every joint" if len(ideal) == len(having) else ", ".join(ideal)
            out.append(Row(kind, (in_words(f"nothing described: {where}"), in_words("ideal"))))
    return out + [
        Row(f"base {kind}", (in_words("nothing described"), in_words("ideal")))
        for kind, state in known.base.items()
        if state == "ideal"
    ]


def _written(given: GivenValue) -> str:
    """Return the key of a value, and the value where the part has one of its own."""
    if given.value is None:
        return given.key
    quantities = list(_quantities(given.part, given.key))
    return f"{given.key} {value_text(given.value, quantities[0] if quantities else None)}"


def value_text(value: object, quantity: Quantity | None) -> str:
    """Return a value (SI) as text, in the unit that suits its size, with its tolerance and its
    range; long tables only by their size.
    """
    value = getattr(value, "load", value)  # of a friction
    if isinstance(value, Toleranced):
        return _toleranced(value, quantity)
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Band):
        return f"{_listed((value.low, value.high), quantity).replace(', ', ' to ')}"
    if isinstance(value, int | float):
        return _listed((value,), quantity)
    if isinstance(value, list | tuple):
        return _listed(value, quantity)
    return f"table of {len(value)}" if isinstance(value, dict) else str(value)


def _toleranced(value: Toleranced, quantity: Quantity | None) -> str:
    if not value.tolerance:
        return value_text(value.nominal, quantity)
    difference = (
        Quantity("K", "1 K") if quantity is not None and quantity.si == ABSOLUTE else quantity
    )
    law = (
        ""
        if value.law == "normal"
        else f" ({value.law})"
        if isinstance(value.law, str)
        else " (its own distribution)"
    )
    return f"{value_text(value.nominal, quantity)} ± {value_text(value.tolerance, difference)}{law}"


def _listed(values: Sequence[Any], quantity: Quantity | None) -> str:
    """Return a short list of numbers in one unit, or of words; of a long one its size."""
    if all(isinstance(each, str) for each in values):
        return ", ".join(values)
    if len(values) <= _WRITTEN_OUT and all(isinstance(each, Toleranced) for each in values):
        return ", ".join(_toleranced(each, quantity) for each in values)
    if len(values) > _WRITTEN_OUT or not all(isinstance(each, int | float) for each in values):
        return f"table of {several(len(values), 'row')}"
    units = _units(max(abs(each) for each in values), quantity)
    texts = [
        (" ".join([", ".join(stated_text((each - zero) / size) for each in values), unit]).strip())
        for unit, size, zero in units
    ]
    return min(texts, key=_significant)


def _significant(text: str) -> int:
    """Return how many digits the longest number of a text has, from its first that is not zero."""
    return max(len(number.replace(".", "").lstrip("0")) for number in re.findall(r"[\d.]+", text))


def _units(value: float, quantity: Quantity | None) -> list[tuple[str, float, float]]:
    """Return the units, the largest first, in which a value (SI) may be written, each with its size
    and its zero in SI.
    """
    if quantity is None or not value:
        return [("", 1.0, 0.0)]
    if quantity.si == ABSOLUTE:
        return [("°C", 1.0, ZERO_CELSIUS)]
    if not quantity.si:
        return [
            ("%", 0.01, 0.0)
            if quantity.example.endswith("%")
            else ("µm/m", 1e-6, 0.0)
            if quantity.example.endswith("µm/m")
            else ("", 1.0, 0.0)
        ]
    choices = _UNITS.get(quantity.si, ((quantity.si, 1.0, 0.0),))
    at = next((k for k, each in enumerate(choices) if value >= each[2]), len(choices) - 1)
    return [(unit, size, 0.0) for unit, size, _ in choices[at : at + 2]]


def _quantities(part: type[Part], key: str) -> Iterable[Quantity]:
    """Yield the quantities that a field of a part takes."""
    field = part.model_fields.get(key)
    if field is not None:
        yield from (each for each in field.metadata if isinstance(each, Quantity))
        yield from _within(field.annotation)


def _within(annotation: object) -> Iterable[Quantity]:
    for each in get_args(annotation):
        if isinstance(each, Quantity):
            yield each
        else:
            yield from _within(each)
