"""Values of an arm as text: a reader of files takes each text back to the value."""

import re
from pathlib import Path

import pytest

import lostmotion
from lostmotion.io.field_schema import inside
from lostmotion.io.stated_values import _text, stated_values
from lostmotion.parts.error_source import Part
from lostmotion.units import Quantity, Toleranced

EXAMPLES = Path(__file__).parents[2] / "examples"
FILES = [path for path in sorted(EXAMPLES.glob("*.toml")) if path.stem != "ur5e"] + [
    EXAMPLES / "ur5e.urdf"
]


def quantities(part):
    """Yield every quantity of a part and of the parts in it: its marker, its value and its text."""
    for name in type(part).model_fields:
        value = getattr(part, name)
        options = inside([type(part)], name)
        for each in value if isinstance(value, list | tuple) else [value]:
            if isinstance(each, Part):
                yield from quantities(each)
        quantity = next((each for each in options if isinstance(each, Quantity)), None)
        if (
            quantity is not None
            and isinstance(value, float | Toleranced)
            and not isinstance(value, bool)
        ):
            yield quantity, value, _text(value, options, 12)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_every_text_is_read_back_to_its_value(path):
    """Units, tolerances and ranges: what is listed can be put into a file, and means the same
    there; no number is a power of ten.
    """
    arm = lostmotion.read(path)
    count = 0
    for quantity, value, text in quantities(arm):
        again, wanted = (
            each if isinstance(each, Toleranced) else Toleranced(each)
            for each in (quantity(text), value)
        )
        assert float(again.nominal) == pytest.approx(float(wanted.nominal), rel=1e-9, abs=1e-15), (
            text
        )
        assert again.tolerance == pytest.approx(wanted.tolerance, rel=1e-9, abs=1e-15), text
        count += 1
    assert count > 5
    texts = [each.text for each in stated_values(arm).values()]
    assert not any(re.search(r"\de[-+]?\d", text) for text in texts)


def test_only_what_is_stated_counts_as_stated():
    """A preset, an assumption and a default are named as what they are."""
    hobby = stated_values(lostmotion.read(EXAMPLES / "printed-hobby-arm.toml"))
    assert (hobby["gearbox of pan", "ratio"].text, hobby["gearbox of pan", "ratio"].reason) == (
        "345",
        "preset hobby servo",
    )
    assert (
        hobby["gearbox of pan", "backlash"].text,
        hobby["gearbox of pan", "backlash"].reason,
    ) == ("1 deg ± 18 arcmin", "")
    assert hobby["link of pan", "length"].reason == "assumed"
    assert hobby["encoder of pan", "noise law"].reason == "default"
    assert ("gearbox of pan", "hysteresis") not in hobby
