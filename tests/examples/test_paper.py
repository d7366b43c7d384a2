"""examples/paper: the comparison runs, names every number of the paper, and the README shows what
it prints.
"""

import re
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "examples" / "paper"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e\d+)?")
# Every result that the paper prints, as it prints it.
PRINTED = (
    "0.00066",
    "2.26′",
    "3.27′",
    "0.00177′",
    "0.5′",
    "1′",
    "60 µm",
    "±30 µm",
    "l/2500",
    "0.91 mm",
    "0.03625 mm",
)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def printed():
    """What run.py prints."""
    run = subprocess.run(
        [sys.executable, str(FOLDER / "run.py"), "--quick"],
        capture_output=True,
        check=True,
        encoding="utf-8",
        timeout=300,
    )
    assert not run.stderr
    return run.stdout


@pytest.mark.parametrize("number", PRINTED)
def test_every_number_of_the_paper_is_compared(printed, number):
    """A reader of the paper finds each of its numbers here."""
    assert number in printed


@pytest.mark.parametrize("number", ["2.2689′", "3.26177′", "3.2707′"])
def test_the_corrected_arithmetic_is_shown(printed, number):
    """And beside it what it must be."""
    assert number in printed


def test_the_printed_extremes_lie_within_what_the_corrected_method_finds(printed):
    """On links of 0.3, 0.4, 0.4 and 0.2 m the largest deviation of 1e4 to 1e6 samples is near 0.91
    mm, the paper's figure.
    """
    largest = {
        row.split("|")[1].strip(): float(row.split("|")[4].split("/")[1])
        for row in printed.splitlines()
        if re.match(r"\| 1e", row)
    }
    assert largest["1e4"] < 0.91 < largest["1e5"]


def test_the_readme_shows_what_the_script_prints(printed):
    """Word for word, and number for number to one unit of the last digit; else run `python
    examples/paper/run.py --readme`. But for the row by finite elements, which have their own tests.
    """
    readme = (FOLDER / "README.md").read_text("utf-8")
    shown = readme.partition("<!-- what run.py prints -->")[2].partition(
        "<!-- end of what run.py prints -->"
    )[0]
    shown = "\n".join(line for line in shown.splitlines() if "finite elements [9]" not in line)
    words = [" ".join(NUMBER.sub("#", text).replace("-", "").split()) for text in (shown, printed)]
    assert words[0] == words[1]
    for old, new in zip(NUMBER.findall(shown), NUMBER.findall(printed), strict=True):
        unit = 10.0 ** -len(old.partition("e")[0].partition(".")[2])
        assert float(new) == pytest.approx(float(old), abs=1.01 * unit), f"README shows {old}"
