"""An arm whose drives are all presets has lengths of one digit, whatever is asked of it."""

from __future__ import annotations

import functools
import re

import pytest

import lostmotion

pytestmark = pytest.mark.usefixtures("few_samples")

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
    "map": lambda path: lostmotion.map(path, poses=64, cell="200 mm", per_cell=2),
    "iso9283": lambda path: lostmotion.iso9283(path, robots=100),
    "target": lambda path: lostmotion.target(path, error="5 mm", poses=8, robots=20, visits=3),
}


@pytest.fixture
def arm(tmp_path):
    """Write an arm of presets alone."""
    path = tmp_path / "arm.toml"
    path.write_text(ARM, "utf-8")
    return path


@pytest.fixture(scope="module")
def sheet_of(tmp_path_factory):
    """Return the sheet of a question about the arm of presets, each asked once."""
    path = tmp_path_factory.mktemp("asked") / "arm.toml"
    path.write_text(ARM, "utf-8")
    return functools.cache(lambda question: ASKED[question](path).sheet)


@pytest.mark.parametrize("question", ASKED)
def test_headline_and_cards_have_one_digit(sheet_of, question):
    """No length of an error has more, no interval stands beside it, and the headline states that
    every drive is assumed; nor has any length in the tables of the errors.
    """
    sheet = sheet_of(question)
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


def computed_sizes(sheet, but=()):
    """Return every computed length and angle in the tables of a sheet whose key is not in `but`."""
    return [
        (section.key, row.label, figure)
        for section in sheet.sections
        if not section.key.startswith(but)
        for row in section.rows
        for figure in row.cells
        if figure.unit in {"m", "rad"} and not figure.stated and not figure.words
    ]


def test_a_comparison_of_assumed_arms_has_one_digit(arm, tmp_path):
    """In the headline, the bars and every table of errors; the statement on trust says why. Where
    the nominal geometry puts the tool rests on no drive.
    """
    other = tmp_path / "other.toml"
    other.write_text(ARM.replace("50 g", "150 g"), "utf-8")
    sheet = lostmotion.compare(arm, other, poses=8, robots=8, visits=3).sheet
    assert "Every drive is assumed (hobby servo)" in dict(sheet.brief)["Trust"]
    bars = [f"{bar.figure} {bar.effect}" for block in sheet.bars for bar in block.bars]
    found = re.findall(LENGTH, " ".join([sheet.verdict, dict(sheet.brief)["Sag"], *bars]))
    assert len(found) > 3
    assert [each for each in found if not re.fullmatch(ONE_DIGIT, each)] == []
    sizes = computed_sizes(sheet, but=("tool_points",))
    assert {key for key, _, _ in sizes} > {"changes", "changes_by_level", "parts", "figures"}
    assert any(figure.unit == "rad" for _, _, figure in sizes)
    texts = [figure.display.removeprefix("-") for _, _, figure in sizes]
    assert [each for each in texts if not re.fullmatch(rf"({ONE_DIGIT}|0) \S+", each)] == []


def test_allowed_sizes_of_an_assumed_arm_have_one_digit(sheet_of):
    """Of what part they may be: angle, length or stiffness; and so has the factor on all errors."""
    sheet = sheet_of("target")
    sizes = [
        cell
        for section in sheet.sections
        if section.key in {"single", "kinds", "together"}
        for row in section.rows
        for cell in row.cells
        if cell.shown not in {"1", "%"} and not cell.stated and not cell.words
    ]
    assert {"rad", "m"} < {cell.unit for cell in sizes}
    texts = [cell.display for cell in sizes]
    assert [each for each in texts if not re.fullmatch(rf"{ONE_DIGIT} \D+", each)] == []
    factor = next(card.number for card in sheet.cards if card.title.startswith("equal factor"))
    assert re.fullmatch(rf"{ONE_DIGIT} times", factor)
    assert factor.removesuffix(" times") in sheet.verdict


def test_a_run_of_an_assumed_arm_and_its_replay_have_one_digit(arm, tmp_path):
    """In headline, cards and tables of the run, and in the headline of a replayed error, whose
    tables compare the last bits of one error.
    """
    swept = {"payload.mass": ["50 g", "150 g"]}
    for by in (None, swept):
        run = lostmotion.sweep(
            arm, by=by, poses=8, robots=8, visits=3, out=tmp_path / f"run{by is None}"
        )
        sheet = run.sheet
        assert "Every drive is assumed (hobby servo)" in sheet.verdict
        cards = [card.number for card in sheet.cards if card.limited_as or "error" in card.title]
        found = re.findall(LENGTH, " ".join([sheet.verdict, *cards]))
        assert len(found) > 2
        assert [each for each in found if not re.fullmatch(ONE_DIGIT, each)] == []
        sizes = computed_sizes(sheet)
        assert sizes
        assert [each for each in sizes if not each[2].assumed] == []
    replayed = lostmotion.replay(run.store.folder)[0].sheet
    assert "Every drive is assumed (hobby servo)" in replayed.verdict
    found = re.findall(LENGTH, replayed.verdict)
    assert len(found) > 2
    assert [each for each in found if not re.fullmatch(ONE_DIGIT, each)] == []


def test_a_task_of_an_assumed_arm_has_one_digit(arm):
    """Its reversal error, on the card and in the tables."""
    poses = "A [deg],B [deg],C [deg]\n0,20,30\n10,30,50\n0,40,40\n"
    arm.with_name("path.csv").write_text(poses, "utf-8")
    task = arm.with_name("task.toml")
    task.write_text('poses = "path.csv"\n[[tolerances]]\nsphere = "20 mm"\n', "utf-8")
    sheet = lostmotion.task(arm, task, robots=32, runs=3).sheet
    sizes = computed_sizes(sheet)
    assert sizes
    assert [each for each in sizes if not each[2].assumed] == []


def test_sized_links_of_an_assumed_arm_have_errors_of_one_digit(arm):
    """In the headline, on the card and in the table of `size`; slopes and deflections of the links
    rest on no drive.
    """
    sheet = lostmotion.size(arm, slope="30 arcmin", deflection=200, poses=8).sheet
    assert "Every drive is assumed (hobby servo)" in sheet.verdict
    error = next(card for card in sheet.cards if "r.m.s." in card.title)
    found = re.findall(LENGTH, f"{error.number} {error.quiet} ")
    found += re.findall(LENGTH, sheet.verdict.partition("r.m.s. tool error")[2])
    assert len(found) == 4
    assert [each for each in found if not re.fullmatch(ONE_DIGIT, each)] == []
    sizes = [each for each in computed_sizes(sheet) if each[0] == "trade"]
    assert len(sizes) > 1
    assert all(figure.assumed for _, _, figure in sizes)


def test_a_stated_drive_has_its_digits(arm):
    """One stated backlash ends it, on every surface."""
    arm.write_text(ARM.replace('"A"\n', '"A"\ngearbox = { backlash = "1 deg" }\n'), "utf-8")
    sheet = ASKED["target"](arm).sheet
    assert "Every drive is assumed" not in sheet.verdict
    assert re.search(r"\d\.\d+ mm \(", sheet.verdict)
