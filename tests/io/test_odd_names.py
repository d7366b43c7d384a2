"""Names of joints as URDFs have them: anything printable, in keys, tables of poses, options and
files.
"""

from __future__ import annotations

import csv
import html
import io
import math
import re
import tomllib

import numpy as np
import pytest

from lostmotion.analyses.accuracy.command import study
from lostmotion.errors import InputError
from lostmotion.io import read
from lostmotion.io.pose_and_zone_text import read_pose
from lostmotion.io.poses import read_poses
from lostmotion.io.sweep_designs import read_design, read_sweep
from lostmotion.io.toml import key_step, key_steps, quoted
from tests.io.conftest import mistakes
from tests.io.urdfs import LIMIT, link, robot

NAMES = [
    "joint_3.0",
    "r2/fixed/waist",
    "_panda0_joint1",
    "a=b, c",
    "[deg]",
    'q"\\',
    "ä <b>&amp;</b>",
    "x" * 80,
    "A.seat",
    "[red]joint[/red]",
]


def escape(name):
    """Write a name as an XML attribute holds it."""
    return name.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")


def with_play(*names):
    """Return a sidecar that gives each of these joints a backlash."""
    return "".join(
        f'[joints.{key_step(name)}]\ngearbox = {{ backlash = "1 arcmin" }}\n' for name in names
    )


def laid(folder, names, sidecar):
    """Write a URDF of joints with these names, with a sidecar, and return its path."""
    parts = [link("l0")]
    for k, name in enumerate(map(escape, names)):
        ends = f'<parent link="l{k}"/><child link="l{k + 1}"/><origin xyz="0.2 0 0.1"/>'
        parts += [
            f'<joint name="{name}" type="revolute">{ends}<axis xyz="0 1 0"/>{LIMIT}</joint>',
            link(f"l{k + 1}", k + 1),
        ]
    path = folder / "r.urdf"
    path.write_text(robot(*parts), encoding="utf-8")
    path.with_suffix(".toml").write_text(sidecar, encoding="utf-8")
    return path


@pytest.fixture
def urdf(tmp_path):
    """Write a URDF of three joints, the middle one with this name, and a sidecar that gives it a
    backlash.
    """

    def write(name, sidecar=None):
        said = with_play(name) if sidecar is None else sidecar
        return laid(tmp_path, ("first", name, "last"), said)

    return write


@pytest.mark.parametrize("name", NAMES)
def test_any_printable_name_may_be_read_swept_and_posed(urdf, tmp_path, name):
    """A name stands in a key of TOML, in a column of poses and in an option, and is the same one
    everywhere.
    """
    path = urdf(name)
    arm = read(path)
    assert arm.moving[1].name == name
    line = io.StringIO()
    csv.writer(line).writerows([["first [deg]", f"{name} [deg]", "last [rad]"], [10, 20, 0.5]])
    table = tmp_path / "poses.csv"
    table.write_text(line.getvalue(), encoding="utf-8")
    expected = [math.radians(10), math.radians(20), 0.5]
    assert read_poses(table, arm)[0] == pytest.approx(expected)
    pose = read_pose(f"first=10deg {name}=20deg, last=0.5rad", arm)
    assert isinstance(pose, np.ndarray)
    assert pose == pytest.approx(expected)
    key = f"joints.{key_step(name)}.gearbox.backlash"
    changed = read_design(path, None, {key: "2 arcmin"})
    assert changed.moving[1].gearbox.backlash.nominal == pytest.approx(
        2 * arm.moving[1].gearbox.backlash.nominal
    )
    sweep = tmp_path / "sweep.toml"
    sweep.write_text(
        f'[sweep.joints.{key_step(name)}.gearbox]\nbacklash = ["1 arcmin", "3 arcmin"]\n',
        encoding="utf-8",
    )
    _, (axis,) = read_sweep(path, None, sweep)
    assert axis.steps == ["joints", name, "gearbox", "backlash"]


def test_any_printable_name_may_be_reported(tmp_path):
    """A name stands in the tables and in the plots of a report as it is in the file."""
    answer = study(read(laid(tmp_path, NAMES, with_play(*NAMES))), 8, 20, 2, 1)
    page = (answer.report(tmp_path / "out") / "report.html").read_text(encoding="utf-8")
    labels = "".join(row.label for section in answer.sheet.sections for row in section.rows)
    plots = "".join(re.findall("<svg.*?</svg>", page, re.DOTALL))
    for name in NAMES:
        assert name in labels
        shown = name if len(name) < 80 else name[:10]  # plots shorten what is too long for them
        assert html.escape(shown, quote=False) in plots
    assert "<b>&amp;</b>" not in page


@pytest.mark.parametrize("name", NAMES)
def test_an_example_with_an_odd_name_passes_when_it_is_pasted(urdf, name):
    """Hints of headers and options hold the names so that they are read again."""
    path = urdf(name)
    arm = read(path)
    with pytest.raises(InputError) as caught:
        read_pose("nobody=3deg", arm)
    ((_, example),) = caught.value.problems[0].passing
    assert len(read_pose(example, arm)) == 3
    with pytest.raises(InputError) as caught:
        read_poses(_written(path.with_name("p.csv"), "nobody [deg]\n1\n"), arm)
    header = next(problem.example for problem in caught.value.problems)
    assert len(read_poses(_written(path.with_name("p.csv"), f"{header}\n1,1,1\n"), arm)[0]) == 3


def _written(path, text):
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", NAMES)
def test_a_mistake_is_reported_under_a_key_of_toml(urdf, name):
    """The key in the message is the key in the file."""
    path = urdf(name, f'[joints.{key_step(name)}]\ngearbox = {{ backlash = "1 kg" }}\n')
    (found,) = mistakes(path)
    assert key_steps(found.key) == ["joints", name, "gearbox", "backlash"]


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_one_step_of_a_key(name):
    """Quoted as TOML quotes it."""
    assert key_steps(f"joints.{key_step(name)}.link") == ["joints", name, "link"]
    assert tomllib.loads(f"[joints.{key_step(name)}]\nname = {quoted(name)}") == {
        "joints": {name: {"name": name}}
    }


def test_blanks_around_a_name_are_no_part_of_it(urdf):
    """Nobody sees them, and nobody writes them in a sidecar."""
    assert read(urdf(" a ", "[joints.a]\n")).moving[1].name == "a"


@pytest.mark.parametrize("name", ["a\u202eb", "x" * 81, ""])
def test_a_name_that_would_spoil_a_screen_is_refused(urdf, name):
    """What cannot be printed, or seen, or is too long for any table."""
    assert mistakes(urdf(name, ""))


@pytest.mark.parametrize("key", ["a..b", '"a', 'a."b"c', "", "a."])
def test_what_is_no_key_has_an_empty_step(key):
    """So that a sweep refuses it."""
    assert not all(key_steps(key))
