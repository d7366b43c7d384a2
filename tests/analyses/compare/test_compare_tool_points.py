"""Commanded tool points of compared arms: closed forms of two planar arms, and every surface that
states the distance.
"""

import json
import math

import numpy as np
import pytest
from scipy.special import ellipe

import lostmotion

VALIDATES = (
    (
        "distance of the commanded tool points of two arms",
        (
            "two planar arms with other link lengths, in closed form: a constant, and an elliptic "
            "integral over the elbow's angle"
        ),
        "1e-12; 0.1 % for the mean over 2 048 poses, which its interval contains",
        "comparison/comparison.py",
    ),
)

ARM = """
name = "planar"
[[joints]]
name = "A"
type = "revolute"
axis = "z"
limits = ["-90 deg", "90 deg"]
gearbox = { ratio = 100, backlash = "1 arcmin" }
link = { length = "400 mm", rigid = true }
[[joints]]
name = "B"
type = "revolute"
axis = "z"
limits = ["-180 deg", "180 deg"]
gearbox = { ratio = 100, backlash = "1 arcmin" }
link = { length = "300 mm", rigid = true }
"""
LONGER = ARM.replace("300 mm", "302.3 mm")
BOTH_LONGER = LONGER.replace("400 mm", "401 mm")
SMALL = {"poses": 2048, "robots": 20, "visits": 2, "threads": 1}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Return the paths of three arms: the last link of one is 2.3 mm longer, and of another also
    the first by 1 mm.
    """
    folder = tmp_path_factory.mktemp("arms")
    for name, text in (
        ("one", ARM),
        ("longer", LONGER),
        ("both", BOTH_LONGER),
        ("narrow", LONGER.replace("180 deg", "170 deg")),
    ):
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    return {path.stem: path for path in folder.iterdir()}


@pytest.fixture(scope="module")
def found(files):
    """Return the comparison of the arm with the one whose last link is longer."""
    return lostmotion.compare(files["one"], files["longer"], **SMALL)


def test_a_longer_last_link_moves_the_tool_by_its_difference_at_every_pose(found):
    """The distance is 2.3 mm at all poses, along the last link."""
    apart = found.changes[0].apart
    assert apart.distances == pytest.approx(np.full(2048, 2.3e-3), rel=1e-12)
    assert (apart.mean.value, apart.p95.value, apart.largest) == pytest.approx(
        (2.3e-3,) * 3, rel=1e-12
    )
    angle = found.arms[0].poses.q.sum(axis=1)
    assert apart.vectors == pytest.approx(
        2.3e-3 * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(2048)]), abs=1e-15
    )


def test_two_longer_links_add_by_the_law_of_cosines(files):
    """The distance is |1 mm e1 + 2.3 mm e12|: its mean over the elbow's angle an elliptic integral,
    the largest 3.3 mm where the arm is stretched.
    """
    first, second = 1e-3, 2.3e-3
    both = lostmotion.compare(files["one"], files["both"], **SMALL).changes[0].apart
    mean = 2 / math.pi * (first + second) * ellipe(4 * first * second / (first + second) ** 2)
    assert both.mean.value == pytest.approx(mean, rel=1e-3)
    assert both.mean.low <= mean <= both.mean.high
    elbow = math.pi * 0.05  # the 5 % of poses with the straightest elbow
    assert both.p95.value == pytest.approx(
        math.sqrt(first**2 + second**2 + 2 * first * second * math.cos(elbow)), rel=1e-3
    )
    assert both.largest == pytest.approx(first + second, rel=1e-4)
    assert both.largest <= first + second


def test_every_surface_states_the_distance(found):
    """Headline, first screen, table, plots and result.json name 2.30 mm and where it is largest."""
    sheet = found.sheet
    assert "their commanded tool points are 2.30 mm apart at every pose" in sheet.verdict
    assert "largest 2.30 mm at A " in dict(sheet.brief)["Tool points"]
    (table,) = (each for each in sheet.sections if each.key == "tool_points")
    assert [row.cells[0].as_shown for row in table.rows[:3]] == pytest.approx([2.3] * 3, rel=1e-9)
    assert any(plot.section == "tool_points" for plot in found.plots)
    (facts,) = json.loads(json.dumps(found.result()))["commanded_tool_points"]
    assert facts["largest_m"] == pytest.approx(2.3e-3)
    assert set(facts["largest_at_joint_values"]) == {"A", "B"}


def test_equal_geometry_is_equal_and_stays_out_of_the_headline(files):
    """An arm and its copy command the same tool points: the table says so, the headline nothing,
    and there is no map.
    """
    same = lostmotion.compare(files["one"], lostmotion.read(files["one"]), **SMALL)
    assert same.changes[0].apart.is_zero
    assert "tool point" not in same.sheet.verdict
    assert dict(same.sheet.brief)["Tool points"].endswith("at the same joint values: equal.")
    assert not [plot for plot in same.plots if plot.section == "tool_points"]


def test_arms_at_other_joint_values_are_not_compared(files):
    """With other joint limits the arms do not stand at the same joint values: no distance is
    stated.
    """
    other = lostmotion.compare(files["one"], files["narrow"], **SMALL)
    assert other.changes[0].apart is None
    assert other.result()["commanded_tool_points"] == [None]
    assert "Tool points" not in dict(other.sheet.brief)
    assert "tool point" not in other.sheet.verdict
    assert not [each for each in other.sheet.sections if each.key == "tool_points"]


def test_several_arms_are_named_each_with_its_distance(files):
    """The headline of three arms names the mean distance of those that differ."""
    found = lostmotion.compare(
        files["one"], files["longer"], files["both"], poses=64, robots=20, visits=2, threads=1
    )
    assert "apart from those of one, on average: longer 2.30 mm, both 2." in found.sheet.verdict
