"""`lostmotion check`: what a file states, assumes and leaves ideal, the static loads, and a picture
of the arm.
"""

from __future__ import annotations

import re
import subprocess
import sys

import numpy as np
import pytest
from lxml import etree

import lostmotion
from lostmotion.errors import InputError, OutputExistsError
from lostmotion.mechanism.even_poses import even_poses
from lostmotion.mechanism.state import state_of
from tests.io.conftest import EXAMPLES

ARM = EXAMPLES / "z-arm.toml"


def _rows(checked, key):
    """Return the rows of a section by label."""
    return {
        row.label: row
        for section in checked.sheet.sections
        if section.key == key
        for row in section.rows
    }


def test_a_check_shows_ranges_masses_and_loads_of_each_joint():
    """Beside the rated torque; the loads of a planar chain by hand: weights times levers when
    stretched out.
    """
    checked = lostmotion.check(ARM)
    rows = _rows(checked, "joints")
    assert [str(figure) for figure in rows["A"].cells] == [
        "-20 … 120°",
        "400 mm",
        "5.85 kg",
        "99.5 N m",
        "167 N m",
    ]
    arm = lostmotion.read(ARM)
    (a, b, c, roll) = (
        next(joint for joint in arm.joints if joint.name == name)
        for name in ("A", "B", "C", "roll")
    )
    levers = (
        0.2 * a.link.total_mass,
        0.4 * b.total_mass,
        0.6 * b.link.total_mass,
        0.8 * c.total_mass,
        0.8 * roll.total_mass,
    )
    # the payload's centre is 30 mm beyond the tool
    tip = 0.9 * roll.link.total_mass + 1.03 * arm.payload.mass
    assert rows["A"].cells[3].as_shown <= 9.80665 * (sum(levers) + tip) * (1 + 1e-9)
    # no pose is exactly horizontal
    assert rows["A"].cells[3].as_shown == pytest.approx(9.80665 * (sum(levers) + tip), rel=0.02)


@pytest.mark.parametrize(
    ("centre", "flange", "point", "moment"),
    [(("40 mm", "0 mm", "0 mm"), 40, -60, 0.44), (None, 100, 0, 0.5)],
)
def test_a_check_shows_the_centre_of_a_tool_from_flange_and_tool_point(
    tmp_path, centre, flange, point, moment
):
    """A gripper of 2 kg on a bar of 400 mm, its centre 40 mm beyond the flange and the tool point
    at 100 mm: the drive holds 2 g (0.4 + 0.04) N m.
    """
    file = tmp_path / "arm.toml"
    stated = f"centre_of_mass = {list(centre)}\n" if centre else ""
    file.write_text(
        'name = "bar"\n[tool]\nmass = "2 kg"\nframe = { xyz = ["100 mm", "0 mm", "0 mm"] }\n'
        + stated
        + "[[joints]]\n"
        'name = "A"\ntype = "revolute"\naxis = "y"\nlimits = ["-90 deg", "90 deg"]\nlink = { '
        'length = "400 mm", rigid = true }\n',
        "utf-8",
    )
    checked = lostmotion.check(file)
    ((name, row),) = _rows(checked, "centres").items()
    assert [str(figure) for figure in row.cells] == [
        f"({flange}, 0, 0) mm",
        f"({point}, 0, 0) mm",
    ]
    assert ("not stated" in name) is (centre is None)
    (line,) = (text for title, text in checked.sheet.brief if title == "tool")
    assert f"at ({flange}, 0, 0) mm from the flange, ({point}, 0, 0) mm from the tool point" in line
    assert _rows(checked, "joints")["A"].cells[3].as_shown == pytest.approx(
        2 * 9.80665 * moment, rel=2e-3
    )


def test_the_poses_of_a_check_include_the_limits():
    """Every joint at either end, and no pose twice."""
    for file in (ARM, EXAMPLES / "ur5e.urdf", EXAMPLES / "planar-2r.toml"):
        arm = lostmotion.read(file)
        q = even_poses(arm)
        assert np.allclose(np.stack([q.min(axis=0), q.max(axis=0)], axis=1), arm.limits, atol=1e-12)
        assert len(np.unique(q, axis=0)) == len(q) < 6000


def test_the_states_are_those_of_a_study():
    """The same table in both, and of a URDF with its sidecar every joint is listed."""
    checked = lostmotion.check(EXAMPLES / "ur5e.urdf")
    assert {row.label for row in _rows(checked, "states").values()} == {
        joint.name for joint in lostmotion.read(EXAMPLES / "ur5e.urdf").moving
    }
    assert checked.result()["states"]["joints"][0]["states"]["stiffness"] == "assumed"
    assert "assumed values" in checked.sheet.verdict


def test_an_arm_of_which_nothing_is_known_is_not_called_accurate(tmp_path):
    """The check says that no accuracy can be predicted, and lists a note of the file once."""
    (tmp_path / "bare.toml").write_text(
        (
            'name = "x"\nnotes = ["a sketch"]\n[[joints]]\nname = "A"\ntype = "revolute"\nlimits '
            '= ["0 deg", "90 deg"]\nlink = { length = "1 m" }\n'
        ),
        "utf-8",
    )
    sheet = lostmotion.check(tmp_path / "bare.toml").sheet
    assert "no accuracy can be predicted" in sheet.verdict
    assert "estimates it by class of drive" in sheet.verdict
    assert sheet.notes.count("a sketch") == 1


def test_a_long_way_is_printed_in_metres_without_a_power_of_ten(tmp_path):
    """As the ±10 m that robot files state for a cart."""
    (tmp_path / "long.toml").write_text(
        (
            'name = "x"\n[[joints]]\nname = "A"\ntype = "prismatic"\nlimits = ["-10 m", "10 m"]\n'
            'link = { length = "1 m" }\n'
        ),
        "utf-8",
    )
    row = _rows(lostmotion.check(tmp_path / "long.toml"), "joints")["A"]
    assert "-10 … 10 m" in [str(each) for each in row.cells]


@pytest.mark.parametrize(
    ("file", "state"),
    [
        ("gearbox/rv-like.toml", {"backlash": "assumed"}),
        ("bearing/6209.toml", {"bearing": "stated"}),
    ],
)
def test_a_gearbox_and_a_bearing_by_themselves_are_checked(file, state, tmp_path, monkeypatch):
    """Each kind of error with its state; there is no picture, and nothing is written."""
    monkeypatch.chdir(tmp_path)
    checked = lostmotion.check(EXAMPLES / file)
    assert state.items() <= checked.result()["known"].items()
    assert checked.picture == ""
    checked.report()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "file", ["z-arm.toml", "ur5e.urdf", "gantry.toml", "scara.toml", "tracked-base.toml"]
)
def test_the_picture_shows_each_joint_in_three_views_to_one_scale(file):
    """Well-formed SVG in which every polygon is within its view; the scale bar has the length that
    it states.
    """
    arm = lostmotion.read(EXAMPLES / file)
    svg = etree.fromstring(lostmotion.check(EXAMPLES / file).picture.encode())
    name = "{http://www.w3.org/2000/svg}"
    texts = [each.text for each in svg.iter(f"{name}text")]
    assert all(texts.count(joint.name) == 3 for joint in arm.moving)
    polygons = [
        np.array([list(map(float, pair.split(","))) for pair in each.get("points").split()])
        for each in svg.iter(f"{name}polygon")
    ]
    assert len(polygons) == 3 * len(arm.bodies)
    panels = [each for each in svg.iter(f"{name}rect") if each.get("width") == "380"]
    for k, panel in enumerate(panels):
        x, y = float(panel.get("x")), float(panel.get("y"))
        drawn = np.concatenate(polygons[k * len(arm.bodies) : (k + 1) * len(arm.bodies)])
        assert x <= drawn[:, 0].min() <= drawn[:, 0].max() <= x + 380
        assert y <= drawn[:, 1].min() <= drawn[:, 1].max() <= y + 380
    side, _, above = (
        np.concatenate(polygons[k * len(arm.bodies) : (k + 1) * len(arm.bodies)]) for k in range(3)
    )
    assert np.ptp(side[:, 0]) == pytest.approx(np.ptp(above[:, 0]), abs=0.3)  # both show x
    bar = float(re.search(r"h([\d.]+)", next(svg.iter(f"{name}path")).get("d"))[1])
    size, unit = next(
        text for text in texts if text.endswith(" mm") or re.fullmatch(r"\d+ m", text)
    ).split()
    corners = np.concatenate(
        [body.corners() @ at[:3, :3].T + at[:3, 3] for body, at in _placed(arm)]
    )
    assert bar / (float(size) * (1e-3 if unit == "mm" else 1)) == pytest.approx(
        np.ptp(side[:, 0]) / np.ptp(corners[:, 0]), rel=0.01
    )


TALL = """
name = "upright"
[[joints]]
name = "shoulder lift joint"
type = "revolute"
axis = "y"
limits = ["-90 deg", "90 deg"]
link = { length = "1200 mm", direction = "z", rigid = true }
[[joints]]
name = "elbow lift joint"
type = "revolute"
axis = "y"
limits = ["-90 deg", "90 deg"]
link = { length = "1200 mm", direction = "z", rigid = true }
"""


@pytest.mark.parametrize(
    "file", ["z-arm.toml", "six-axis.toml", "planar-2r.toml", "gantry.toml", "upright"]
)
def test_nothing_is_drawn_over_the_titles_of_a_picture(file, tmp_path):
    """No body and no joint's name reaches into a title, however tall the arm: a tall arm fills its
    view up to the top.
    """
    path = EXAMPLES / file
    if file == "upright":
        path = tmp_path / "arm.toml"
        path.write_text(TALL, "utf-8")
    svg = etree.fromstring(lostmotion.check(path).picture.encode())
    name, height = "{http://www.w3.org/2000/svg}", 13
    words = [
        (each.text or "", float(each.get("x")), float(each.get("y")))
        for each in svg.iter(f"{name}text")
    ]
    titles = [each for each in words if "→" in each[0]]
    joints = [
        each for each in words if each[0] in {joint.name for joint in lostmotion.read(path).moving}
    ]
    points = [
        tuple(map(float, pair.split(",")))
        for each in svg.iter(f"{name}polygon")
        for pair in each.get("points").split()
    ]
    assert len(titles) == 3
    for title, left, base in titles:
        for x, y in [*points, *((x, y - height) for _, x, y in joints)]:
            assert not (left <= x <= left + 7 * len(title) and base - height < y < base + 3), title


def _placed(arm):
    """Return each body with the frame of its place in the middle of all ranges."""
    at = state_of(arm, arm.limits.mean(axis=1)[None]).frames[:, 0]
    return [(body, at[body.place]) for body in arm.bodies]


def test_a_picture_replaces_an_earlier_one_and_nothing_else(tmp_path):
    """A stranger's SVG stays."""
    target = tmp_path / "z-arm.svg"
    checked = lostmotion.check(ARM, out=target)
    assert checked.report() == checked.report() == target
    target.write_text("<svg/>", "utf-8")
    with pytest.raises(OutputExistsError):
        checked.report()
    assert target.read_text("utf-8") == "<svg/>"


def test_a_check_draws_no_samples_and_compiles_nothing(tmp_path):
    """The command loads neither Numba nor SciPy's distributions nor matplotlib, prints the table,
    and names the picture.
    """
    code = (
        f"import sys; sys.argv = ['lostmotion', 'check', {str(ARM)!r}]\nfrom lostmotion.cli "
        "import main\ntry:\n    main()\nexcept SystemExit:\n"
        "    sys.__stderr__.write(' '.join(m for m in ('scipy.stats', 'matplotlib', 'xarray', "
        "'numba') if m in sys.modules))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert done.stderr == ""
    assert "Picture: z-arm.svg" in done.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["z-arm.svg"]


def test_a_mistake_is_reported_with_its_line(tmp_path):
    """As every command reports it."""
    (tmp_path / "arm.toml").write_text(
        ARM.read_text("utf-8").replace('mass = "5 kg"', 'mass = "5 m"', 1), "utf-8"
    )
    line = (
        ARM.read_text("utf-8")
        .split("\n")
        .index(
            next(
                row for row in ARM.read_text("utf-8").split("\n") if row.startswith('mass = "5 kg"')
            )
        )
        + 1
    )
    with pytest.raises(InputError) as caught:
        lostmotion.check(tmp_path / "arm.toml")
    assert [problem.file for problem in caught.value.problems] == [
        f"{tmp_path / 'arm.toml'}:{line}"
    ]


def test_the_loops_of_a_closed_chain_are_in_the_table_and_in_the_picture():
    """Each closure with how often it is over-constrained, and a ring where it closes; passive
    joints are hollow, and drives are named.
    """
    checked = lostmotion.check(EXAMPLES / "closed-chains" / "five-bar.toml")
    (row,) = _rows(checked, "loops").values()
    assert row.label == "left-elbow.tip = pin.tip"
    assert [str(cell) for cell in row.cells] == [
        "over-constrained 3 times",
        "left-elbow, right-elbow, pin",
    ]
    drawn = etree.fromstring(checked.picture.encode())
    rings = [each for each in drawn.iter("{*}circle") if each.get("fill") == "none"]
    assert len(rings) == 3
    at = state_of(checked.arm, checked.arm.home[None]).frames[:, 0]
    joined = (at[checked.arm.places.index(name)] for name in ("left-elbow.tip", "pin.tip"))
    np.testing.assert_allclose(*joined, atol=1e-8)
    words = [each.text for each in drawn.iter("{*}text")]
    assert {"left", "right"} <= set(words)
    assert not {"left-elbow", "pin"} & set(words)
    assert any("hollow: passive joint; ring: closure" in word for word in words)
    assert checked.sheet.about.startswith("2 driven joints and 3 passive, ")
    assert (checked.sheet.cards[0].number, checked.sheet.cards[0].quiet) == ("2", "3 passive")
