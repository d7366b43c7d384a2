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
import tomllib
from pathlib import Path
from typing import NamedTuple

import pytest

from lostmotion.compile_cache import folder_of
from lostmotion.source_hash import LAYERS
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


def _heading(block: Snippet) -> str:
    above = "\n".join(PAGE.read_text("utf-8").splitlines()[: block.line])
    return re.findall(r"^## (.+)$", above, re.MULTILINE)[-1]


def _change(block: Snippet) -> Change:
    heading = _heading(block)
    first, _, rest = block.text.partition("\n")
    if block.language in FRESH:
        return Change(heading, first.removeprefix("# "), "", block.text)
    lines = [line if line.strip() else " \n" for line in rest.splitlines(keepends=True)]
    assert all(line[0] in " +" for line in lines)
    before, after = (
        "".join(line[1:] for line in lines if line[0] in kinds) for kinds in (" ", " +")
    )
    return Change(heading, first.removeprefix("+++ "), before, after)


EVERY = [
    _change(block) for language in ("python", "toml", "diff") for block in snippets(PAGE, language)
]
# The last part of the page is a package of its own.
OUTSIDE = "From another package"
CHANGES = [change for change in EVERY if change.heading != OUTSIDE]


COMMANDS = """
import json, sys
from tests.command import carried_out
done = [carried_out(*words, cwd=".", columns=200) for words in json.loads(sys.argv[1])]
print(json.dumps([(each.returncode, each.stdout, each.stderr) for each in done]))
"""


class Copy(NamedTuple):
    """The package with the page's changes, beside a folder to work in."""

    folder: Path
    work: Path

    def run(self, *words, check=0):
        """Run Python on the changed package; return what it prints, or what it complains of."""
        path = os.pathsep.join([str(self.folder), os.environ.get("PYTHONPATH", ""), str(ROOT)])
        environment = {**os.environ, "PYTHONPATH": path, "COLUMNS": "200"}
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

    def carried_out(self, *commands, check=0):
        """Carry out commands one after the other in one process: Python loads the libraries once.
        Return what each prints, or what it complains of.
        """
        found = json.loads(self.run("-c", COMMANDS, json.dumps(commands)))
        assert {code for code, *_ in found} == {check}, found
        return [out if check == 0 else err for _, out, err in found]


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """Apply every block of the page to a copy, and run its commands from top to bottom."""
    made = Copy(tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("work"))
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
    _take_kernels(made)
    # the closed form is that of every pose
    made.carried_out(
        *(
            [*words, *(("--poses", "16") if "study" in words else ())]
            for words in _commands(outside=False)
        )
    )
    return made


def _take_kernels(made: Copy) -> None:
    """Copy the compiled kernels to where the changed package looks for its own: no block changes a
    kernel or what one reads, but the hash of a layer covers all of its files.
    """
    asked = "from lostmotion.compile_cache import folder_of as at\nfor each in {}: print(at(each))"
    own = made.run("-c", asked.format(LAYERS)).splitlines()
    for layer, folder in zip(LAYERS, own, strict=True):
        usual = folder_of(layer)
        if usual and usual.is_dir() and not Path(folder).is_dir():
            shutil.copytree(usual, folder)


def _commands(*, outside: bool) -> list[list[str]]:
    """Return the words after `lostmotion` in the commands of the page, those of the package of its
    own or the others.
    """
    return [
        shlex.split(line.removeprefix("lostmotion "))
        for block in snippets(PAGE, "sh")
        if (_heading(block) == OUTSIDE) is outside
        for line in block.text.splitlines()
    ]


def installed(folder: Path, entries: str, **files: str) -> Path:
    """Put a package into a folder as an installer would: its modules, and its metadata with the
    entry points.
    """
    metadata = folder / "acme_robots-1.2.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: acme-robots\nVersion: 1.2\n")
    (metadata / "entry_points.txt").write_text(entries)
    (folder / "acme_robots").mkdir()
    for name, text in {"__init__": "", **files}.items():
        (folder / "acme_robots" / f"{name}.py").write_text(text, "utf-8")
    return folder


@pytest.fixture(scope="module")
def outside(tmp_path_factory):
    """Install the page's package beside the source as it is."""
    every = {change.file: change.after for change in EVERY}
    project = tomllib.loads(every["pyproject.toml"])["project"]
    entries = "".join(
        f"[{group}]\n" + "".join(f"{name} = {target}\n" for name, target in named.items())
        for group, named in project["entry-points"].items()
    )
    folder = installed(
        tmp_path_factory.mktemp("site"),
        entries,
        spur=every["parts/gearbox/spur.py"],
        joints=every["acme_robots/joints.py"],
        figures=every["acme_robots/figures.py"],
    )
    work = tmp_path_factory.mktemp("asked")
    (work / "one-joint.toml").write_text(every["one-joint.toml"], "utf-8")
    return Copy(folder, work)


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
    assert plot == "analyses/accuracy/page/plots.py"
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
    (message,) = copy.carried_out(["study", "wrong.toml"], check=2)
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
    listed, explained, schema = copy.carried_out(["--help"], ["resolution", "--help"], ["schema"])
    assert re.search(r"^ +resolution +Report how far", listed, re.MULTILINE)
    assert "Smallest turn of each joint, '1 arcmin'. Default: 1 arcmin." in " ".join(
        explained.split()
    )
    assert "SpurGearbox" in schema
    (message,) = copy.carried_out(
        ["resolution", "one-joint.toml", "--increment", "0 arcmin"], check=2
    )
    assert "--increment" in message
    assert "1 arcmin" in message


def test_a_package_brings_a_gearbox_kind_a_figure_and_a_question(outside):
    """The commands of the page run; help and Python have the question; another arm is as before."""
    names, checked, listed = outside.carried_out(*_commands(outside=True), ["--help"])
    assert names == "A\n"
    assert "one joint" in checked
    assert re.search(r"^  joints +List the joints", listed, re.MULTILINE)
    code = """
import lostmotion
arm = lostmotion.read("one-joint.toml")
print(lostmotion.joints(arm), "joints" in dir(lostmotion), type(arm.joints[0].gearbox).__name__)
from lostmotion.runs.job import made_with
print(made_with()["acme-robots"])
from lostmotion.propagation.error_samples import Drawn
from lostmotion.propagation.figures import figures_of
from lostmotion.propagation.montecarlo.montecarlo import run
errors = Drawn.of(run(arm, lostmotion.sample_poses(arm, 8), 4, 2, 1))
print("p25" in figures_of(errors), errors.quantile(0.25) == figures_of(errors)["p25"].of(errors))
"""
    assert outside.run("-c", code) == "['A'] True SpurGearbox\n1.2\nTrue True\n"


BROKEN = {
    "missing": "[lostmotion.parts]\nx = acme_robots.nothing:X\n",
    "raises": "[lostmotion.parts]\nx = acme_robots.raises:X\n",
    "no kind": "[lostmotion.parts]\nx = acme_robots:__name__\n",
    "a kind twice": "[lostmotion.parts]\nx = lostmotion.parts.gearbox:WormGearbox\n",
    "a question twice": "[lostmotion.questions]\nstudy = acme_robots:study\n",
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_package_that_cannot_be_used_is_one_message_that_names_it(case, tmp_path):
    """Refused with exit code 2 and no traceback: package, version, entry point, and what to do."""
    folder = installed(tmp_path / "site", BROKEN[case], raises="1 / 0")
    arm = ROOT / "examples" / "z-arm.toml"
    message = Copy(folder, tmp_path).run("-m", "lostmotion", "check", str(arm), check=2)
    assert "package acme-robots 1.2: lostmotion." in message
    assert "pip uninstall acme-robots" in message
    assert "Traceback" not in message
    assert message.count("found ") == 1


def test_a_broken_question_leaves_the_others_alone(tmp_path):
    """`--help` lists it with the reason; asked, it is refused; other commands run."""
    entries = "[lostmotion.questions]\nx = acme_robots.nothing:x\n"
    copy = Copy(installed(tmp_path / "site", entries), tmp_path)
    listed = copy.run("-m", "lostmotion", "--help")
    assert re.search(r"^  x +Cannot be loaded: package acme-robots", listed, re.MULTILINE)
    message = copy.run("-m", "lostmotion", "x", "arm.toml", check=2)
    assert 'lostmotion.questions, x = "acme_robots.nothing:x"' in message
    assert "Traceback" not in message
    assert copy.run("-m", "lostmotion", "catalog", "RV-40E-121")
