"""docs/extending.md, applied to a copy of the source: it shows everything that must be written, and
the results are those of closed forms.
"""

from __future__ import annotations

import doctest
import json
import math
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.docs.pages import ROOT, Snippet, snippets

PAGE = ROOT / "docs" / "extending.md"
FRESH = ("python", "toml")


class Change(NamedTuple):
    """A block of the page that writes a file, or changes one: where the reader finds it, the file,
    and the lines before and after.
    """

    heading: str
    file: str
    before: str
    after: str

    @property
    def added(self) -> int:
        """Return how many lines it adds."""
        return self.after.count("\n") - self.before.count("\n")


def _change(block: Snippet) -> Change:
    above = "\n".join(PAGE.read_text("utf-8").splitlines()[: block.line])
    heading = re.findall(r"^## (.+)$", above, re.MULTILINE)[-1]
    first, _, rest = block.text.partition("\n")
    if block.language in FRESH:
        return Change(heading, first.removeprefix("# "), "", block.text)
    lines = [line if line.strip() else " \n" for line in rest.splitlines(keepends=True)]
    assert all(line[0] in " +" for line in lines)
    before, after = (
        "".join(line[1:] for line in lines if line[0] in kinds) for kinds in (" ", " +")
    )
    return Change(heading, first.removeprefix("+++ "), before, after)


CHANGES = [
    _change(block) for language in ("python", "toml", "diff") for block in snippets(PAGE, language)
]


class Copy(NamedTuple):
    """The package with the page's changes, beside a folder to work in."""

    folder: Path
    work: Path

    def run(self, *words, check=0):
        """Run Python on the changed package; return what it prints, or what it complains of."""
        environment = {**os.environ, "PYTHONPATH": str(self.folder), "COLUMNS": "200"}
        done = subprocess.run(
            [sys.executable, *words],
            cwd=self.work,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == check, done.stderr
        return done.stdout if check == 0 else done.stderr


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """Apply every block of the page to a copy, and run its commands from top to bottom."""
    made = Copy(tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("work"))
    # compiled kernels with it
    shutil.copytree(ROOT / "src" / "lostmotion", made.folder / "lostmotion")
    for change in CHANGES:
        path = (
            made.work if change.file.endswith(".toml") else made.folder / "lostmotion"
        ) / change.file
        path.parent.mkdir(exist_ok=True)
        text = path.read_text("utf-8") if change.before else ""
        assert text.count(change.before) == 1 or not change.before, change
        path.write_text(
            text.replace(change.before, change.after) if change.before else change.after, "utf-8"
        )
    for block in snippets(PAGE, "sh"):
        for line in block.text.splitlines():
            made.run("-m", *shlex.split(line))
    return made


def _figures(copy, folder):
    return json.loads((copy.work / folder / "result.json").read_text("utf-8"))["figures"]


def test_each_extension_costs_what_the_page_promises():
    """A gearbox kind is one new file and one line, a row or a plot changes one file, a question is
    one new folder and one line.
    """
    kind, figure, question = (
        [
            change
            for change in CHANGES
            if change.heading == heading and not change.file.endswith(".toml")
        ]
        for heading in ("A gearbox kind", "A figure in a report", "A question")
    )
    assert [change.file for change in kind if not change.before] == ["parts/gearbox/spur.py"]
    assert [change.added for change in kind if change.before] == [1]
    assert all(change.before for change in figure)
    row, plot = dict.fromkeys(change.file for change in figure)
    assert [change.added for change in figure if change.file == row] == [1]
    assert plot.startswith("analyses/accuracy/plots/")
    assert {str(Path(change.file).parent) for change in question if not change.before} == {
        "analyses/resolution"
    }
    assert [change.added for change in question if change.before] == [1]
    assert len(CHANGES) == len([*kind, *figure, *question]) + 1


@pytest.mark.slow
def test_the_new_gearbox_errs_as_its_closed_form(copy):
    """Backlash to either side and a harmonic of the pinion: the r.m.s. rotation is √(b²/4 + a²/2),
    of which the pinion has its share.
    """
    found = _figures(copy, "one-joint-accuracy")
    backlash, amplitude = math.radians(2 / 60), math.radians(0.5 / 60)
    square = backlash**2 / 4 + amplitude**2 / 2
    assert found["error"]["rotation_rms"]["value"] == pytest.approx(math.sqrt(square), rel=1e-9)
    assert found["causes"]["gearbox_pinion"]["share"]["value"] == pytest.approx(
        amplitude**2 / 2 / square, rel=1e-9
    )
    assert found["states"]["A"]["transm_error"]["words"] == "stated"
    waves = json.dumps(_figures(copy, "one-joint-gearbox"))
    assert "pinion" in waves
    assert "SpurGearbox" in copy.run("-m", "lostmotion", "schema")


@pytest.mark.slow
def test_a_mistake_in_the_new_gearbox_is_refused_as_in_any_other(copy):
    """A length where an angle belongs, and an unknown key, are refused with what is expected."""
    text = (copy.work / "one-joint.toml").read_text("utf-8")
    wrong = copy.work / "wrong.toml"
    wrong.write_text(
        text.replace(
            'pinion_error = "0.5 arcmin"', 'pinion_error = "5 mm", wheel_eror = "1 arcmin"'
        ),
        "utf-8",
    )
    message = copy.run("-m", "lostmotion", "study", "wrong.toml", check=2)
    assert "pinion_error" in message
    assert "5 mm" in message
    assert "wheel_error" in message


@pytest.mark.slow
def test_the_new_figure_and_the_new_plot_are_shown(copy):
    """Only the first of two joints has backlash. One declaration is a row, a key of result.json, an
    attribute and a line of the frame.
    """
    joint = (
        '[[joints]]\nname = "{}"\ntype = "revolute"\naxis = "z"\nlimits = ["-180 deg", "180 deg"]\n'
        'link = {{ length = "1 m", rigid = true }}\n'
    )
    arm = (
        'name = "two"\n'
        + joint.format("A")
        + 'gearbox = { backlash = "2 arcmin" }\n'
        + joint.format("B")
    )
    (copy.work / "two.toml").write_text(arm, "utf-8")
    code = """
import json, lostmotion, numpy
s = lostmotion.study("two.toml", poses=numpy.array([[0.0, 0.0], [0.0, numpy.pi / 2]]), robots=50, visits=10)
plot = next(each for each in s.plots if each.key == "error-distribution")
line = plot.figure.axes[0].lines[0]
row = s.result()["figures"]["error"]["p25"]
print(json.dumps({"p25": row["value"], "of_python": s.p25.value, "name": s.frame().name["p25"], "x": list(map(float, line.get_xdata())), "y": list(map(float, line.get_ydata()))}))
"""
    found = json.loads(copy.run("-c", code))
    assert 0 < found["p25"] == found["of_python"] < 1e-3
    assert found["name"] == "25th percentile"
    small = math.radians(1 / 60) * 1e3  # mm at 1 m
    share = {
        round(y, 6)
        for x, y in zip(found["x"], found["y"], strict=True)
        if 1.5 * small < x < 1.9 * small
    }
    assert share == {50.0}
    assert found["y"][-1] == pytest.approx(100)


@pytest.mark.slow
def test_the_new_question_is_asked_from_python_and_from_the_command_line(copy):
    """Both give increment times arm length; `--help` lists the question and its argument; a mistake
    is refused with an example.
    """
    (block,) = snippets(PAGE, "pycon")
    examples = doctest.DocTestParser().get_examples(block.text)
    assert len(examples) == 3
    code = (
        "import doctest\n"
        f"text = {block.text!r}\n"
        "test = doctest.DocTestParser().get_doctest(text, {}, 'page', None, 0)\n"
    )
    assert "failed=0, attempted=3" in copy.run(
        "-c", code + "print(doctest.DocTestRunner().run(test))"
    )
    found = _figures(copy, "one-joint-resolution")
    expected = math.radians(30 / 3600)
    assert found["steps"]["A"]["largest"]["value"] == pytest.approx(expected, rel=1e-9)
    assert found["steps"]["A"]["mean"]["value"] == pytest.approx(expected, rel=1e-9)
    assert (copy.work / "one-joint-resolution" / "report.html").stat().st_size > 1000
    assert re.search(
        r"^ +resolution +Report how far", copy.run("-m", "lostmotion", "--help"), re.MULTILINE
    )
    assert "Smallest turn of each joint, '1 arcmin'. Default: 1 arcmin." in " ".join(
        copy.run("-m", "lostmotion", "resolution", "--help").split()
    )
    message = copy.run(
        "-m", "lostmotion", "resolution", "one-joint.toml", "--increment", "0 arcmin", check=2
    )
    assert "--increment" in message
    assert "1 arcmin" in message
