"""A table of numbers: each in the unit of its column, counted from the same samples."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lostmotion.error_model.intervals import Estimate
from lostmotion.reporting.sheet import Cell, Row, in_words, table


def test_numbers_stand_in_the_unit_of_their_column():
    """A printed unit is that of every row; in an SI unit each number is shown as its size suits."""
    found = table("k", "T", {"play": "µm", "shift": "m"}, [("a", 2e-6, 3e-6), ("b", 0.002, 0.003)])
    assert found.columns == ("play", "shift")
    assert [[str(each) for each in row.cells] for row in found.rows] == [
        ["2.00 µm", "3.00 µm"],
        ["2000 µm", "3.00 mm"],
    ]


def test_a_value_is_whatever_a_table_prints():
    """Counts stay counts, estimates keep their intervals, a text is a cell, and nothing is not
    known.
    """
    cells = table(
        "k",
        "T",
        ("value",),
        [
            ("count", np.int64(3)),
            ("estimate", Estimate(0.1, 0.08, 0.12)),
            ("text", "rigid"),
            ("none", None),
            ("own", Cell(5.0, "kg", samples="a scale")),
            Row("row", (in_words("as it is"),)),
        ],
        unit="%",
        samples="9 robots",
    ).rows
    assert [row.cells[0].display for row in cells] == [
        "3 %",
        "10.0 % (8.0 … 12.0)",
        "rigid",
        "not known",
        "5.00 kg",
        "as it is",
    ]
    assert [row.cells[0].samples for row in cells] == ["9 robots"] * 2 + ["", "9 robots"] + [
        "a scale",
        "",
    ]
    assert type(cells[0].cells[0].value) is int
    assert math.isnan(cells[3].cells[0].value)


def test_a_row_has_a_note_only_behind_all_its_values():
    """One entry more than columns is a note; any other length is a mistake."""
    assert table("k", "T", ("a", "b"), [("x", 1.0, 2.0, "note")]).rows[0].note == "note"
    for row in (("x", 1.0), ("x", 1.0, 2.0, "note", 3.0)):
        with pytest.raises(ValueError, match="zip"):
            table("k", "T", ("a", "b"), [row])
