"""An arm whose drives are all presets has lengths of one digit, whatever is asked of it."""

from __future__ import annotations

import re

import pytest

import lostmotion

HEAD = 'name = "assumed"\npresets = { revolute = "hobby servo", link = "printed PLA" }\n'
JOINTS = "".join(
    f'[[joints]]\nname = "{name}"\ntype = "revolute"\naxis = "{axis}"\nlimits = ["-90 deg", '
    f'"90 deg"]\nlink = {{ length = "{length} mm", mass = "0.1 kg" }}\n'
    for name, axis, length in (("A", "z", 60), ("B", "-y", 120), ("C", "-y", 110))
)
ARM = f'{HEAD}[payload]\nmass = "50 g"\n{JOINTS}'
# Lengths that are printed with their unit, and the digits of one.
LENGTH = r"([0-9.]+) (?:mm|µm)\b"
ONE_DIGIT = r"0*\.?0*[1-9]0*"

TABLES = ("map", "rp100", "target")
ASKED = {
    "map": lambda path: lostmotion.map(path, poses=256),
    "iso9283": lambda path: lostmotion.iso9283(path, robots=100),
    "target": lambda path: lostmotion.target(path, error="5 mm", poses=64, robots=32, visits=3),
}


@pytest.fixture
def arm(tmp_path):
    """Write an arm of presets alone."""
    path = tmp_path / "arm.toml"
    path.write_text(ARM, "utf-8")
    return path


@pytest.mark.parametrize("question", ASKED)
def test_headline_and_cards_have_one_digit(arm, question):
    """No length of an error has more, no interval stands beside it, and the headline states that
    every drive is assumed; nor has any length in the tables of the errors.
    """
    sheet = ASKED[question](arm).sheet
    assert "Every drive is assumed (hobby servo)" in sheet.verdict
    errors = [card.number for card in sheet.cards if card.limited_as or card.title == "as stated"]
    texts = [sheet.verdict, *errors, *(card.number for card in sheet.cards if "RP" in card.title)]
    found = re.findall(LENGTH, " ".join(texts))
    assert len(found) > 1
    assert [each for each in found if not re.fullmatch(ONE_DIGIT, each)] == []
    assert not re.search(rf"{LENGTH} \([0-9.]+ …", sheet.verdict)
    figures = [
        figure
        for section in sheet.sections
        if section.key in TABLES
        for row in section.rows
        for figure in row.cells
        if figure.unit == "m" and not figure.stated and not figure.words
    ]
    assert figures
    assert all(figure.assumed for figure in figures)


def test_a_comparison_of_assumed_arms_has_one_digit(arm, tmp_path):
    """In the headline and the bars; the statement on trust says why."""
    other = tmp_path / "other.toml"
    other.write_text(ARM.replace("50 g", "150 g"), "utf-8")
    sheet = lostmotion.compare(arm, other, poses=64, robots=32, visits=3).sheet
    assert "Every drive is assumed (hobby servo)" in dict(sheet.brief)["Trust"]
    bars = [f"{bar.figure} {bar.effect}" for block in sheet.bars for bar in block.bars]
    found = re.findall(LENGTH, " ".join([sheet.verdict, dict(sheet.brief)["Sag"], *bars]))
    assert len(found) > 3
    assert [each for each in found if not re.fullmatch(ONE_DIGIT, each)] == []


def test_a_stated_drive_has_its_digits(arm):
    """One stated backlash ends it, on every surface."""
    arm.write_text(ARM.replace('"A"\n', '"A"\ngearbox = { backlash = "1 deg" }\n'), "utf-8")
    sheet = ASKED["target"](arm).sheet
    assert "Every drive is assumed" not in sheet.verdict
    assert re.search(r"\d\.\d+ mm \(", sheet.verdict)
