"""A drive that holds more than it is rated for is reported before anything else, in every
command.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import lostmotion
from lostmotion.cli import app
from lostmotion.error_model.overload import overloads
from lostmotion.error_model.poses import Poses

pytestmark = pytest.mark.usefixtures("few_samples", "unpainted")

_ARM = """
name = "servo arm"
[payload]
mass = "{payload}"
[gearboxes.servo]
ratio = 200
rated_torque = "0.9 N m"
backlash = "20 arcmin"
stiffness = "0.5 N m/arcmin"
[[joints]]
name = "turret"
type = "revolute"
axis = "z"
limits = ["-90 deg", "90 deg"]
gearbox = "servo"
[[joints]]
name = "shoulder"
type = "revolute"
axis = "y"
limits = ["-90 deg", "90 deg"]
gearbox = "servo"
link = {{ length = "200 mm ± 0.2 mm", section = {{ kind = "rod", diameter = "10 mm" }}, material = "aluminium" }}
"""


@pytest.fixture
def arm_file(tmp_path):
    """A servo rated 0.9 N m that holds half a kilogram 200 mm away, some 1.1 N m."""
    file = tmp_path / "servo.toml"
    file.write_text(_ARM.format(payload="500 g"), encoding="utf-8")
    return file


def test_held_torque_is_that_of_the_lever(arm_file):
    """A horizontal lever of a payload and a uniform rod asks m g l + w l^2 / 2 of its joint, and no
    more in any other pose.
    """
    arm = lostmotion.read(arm_file)
    (found,) = overloads(arm)
    rod = arm.joints[1].link.total_mass
    exact = 9.80665 * 0.2 * (0.5 + rod / 2)
    assert found.joint == "shoulder"
    assert found.rated == pytest.approx(0.9)
    assert found.held == pytest.approx(exact, rel=1e-3)
    assert found.held <= exact * (1 + 1e-12)
    (at_the_horizontal,) = overloads(arm, Poses(np.array([[0.0, np.pi / 2], [0.0, 0.0]]), "given"))
    assert at_the_horizontal.held == pytest.approx(exact, rel=1e-9)


def test_a_drive_within_its_rating_is_not_reported(tmp_path):
    """A payload that the servo is rated for raises no warning, and neither does a joint whose rated
    torque nobody stated.
    """
    file = tmp_path / "servo.toml"
    file.write_text(_ARM.format(payload="300 g"), encoding="utf-8")
    assert overloads(lostmotion.read(file)) == ()
    file.write_text(
        _ARM.format(payload="500 g").replace('rated_torque = "0.9 N m"\n', ""), encoding="utf-8"
    )
    arm = lostmotion.read(file)
    assert overloads(arm) == ()
    assert (
        "rated torque of the gearbox of turret, shoulder: not stated, so overload is not "
        "checked there"
    ) in arm.remarks


@pytest.mark.parametrize(
    "words",
    [
        ["run", "--poses", "8", "--robots", "10", "--visits", "2"],
        ["run", "--poses", "8", "--method", "analytic"],
        ["statics", "--poses", "8"],
        ["map", "--poses", "256"],
        ["target", "--error", "5 mm", "--poses", "8", "--robots", "20", "--visits", "2"],
        ["size", "--poses", "8"],
    ],
    ids=lambda words: "-".join(words[:1] + words[3:5]),
)
def test_every_command_warns(arm_file, tmp_path, words):
    """The warning names the joint, what it holds and what it is rated for: on the screen, in the
    report and in result.json.
    """
    out = tmp_path / "out"
    ran = CliRunner().invoke(app, [words[0], str(arm_file), "--out", str(out), *words[1:]])
    assert ran.exit_code == 0, (ran.output, ran.exception)
    screen = " ".join(ran.output.split())
    assert "warning: joint shoulder is overloaded" in screen
    assert "rated 0.9 N m" in screen
    warnings = json.loads((out / "result.json").read_text(encoding="utf-8"))["warnings"]
    # eight poses are few, and have a warning of their own
    (said,) = (warning for warning in warnings if "overloaded" in warning)
    assert said.startswith("joint shoulder is overloaded: it holds up to 1.")
    assert "joint shoulder is overloaded" in (out / "report.html").read_text(encoding="utf-8")


def test_the_iso_sheet_and_a_sweep_warn(tmp_path):
    """With five times the payload shoulder and elbow of the Z-arm are overloaded: its ISO sheet
    says so, and a sweep counts the designs.
    """
    text = Path("examples/z-arm.toml").read_text(encoding="utf-8")
    file = tmp_path / "z.toml"
    file.write_text(text.replace('mass = "5 kg"\n', 'mass = "25 kg"\n'), encoding="utf-8")
    sheet = lostmotion.iso9283(
        lostmotion.read(file), robots=3, visits=2, cube="100 mm", centre="700 mm, 0 mm, 400 mm"
    ).sheet
    assert [warning.split(":")[0] for warning in sheet.warnings] == [
        "joint A is overloaded",
        "joint B is overloaded",
    ]
    file.write_text(
        text + '\n[sweep]\n"payload.mass" = ["5 kg", "20 kg", "25 kg"]\n', encoding="utf-8"
    )
    warnings = lostmotion.sweep(
        file, poses=8, robots=3, visits=2, out=tmp_path / "run"
    ).sheet.warnings
    (of_shoulder,) = (warning for warning in warnings if "joint A is overloaded" in warning)
    assert of_shoulder.startswith("in 2 designs of 3, the worst mass 25 kg")
    assert "25 kg" in of_shoulder
