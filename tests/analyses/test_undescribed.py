"""An arm of which no error source is described has no accuracy that could be predicted."""

from __future__ import annotations

import dataclasses
import json
import re

import pytest
from typer.testing import CliRunner

import lostmotion
from lostmotion.cli.app import app
from lostmotion.error_model.provenance import NOT_DESCRIBED, states
from lostmotion.io.drive_loads import drive_loads
from lostmotion.io.skeleton import skeleton
from lostmotion.mechanism.arm import Arm
from lostmotion.parts.joint import PrismaticJoint, RevoluteJoint
from lostmotion.parts.link import Link
from tests.reporting.first_screen import first_screen

run_command = CliRunner().invoke
BODY = (
    '<inertial><origin xyz="0 0 0.1"/><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" '
    'iyz="0" izz="1"/></inertial>'
)
NATIVE = """name = "x"
[[joints]]
name = "A"
type = "revolute"
axis = "y"
limits = ["-90 deg", "90 deg"]
link = { length = "500 mm", mass = "2 kg" }
[[joints]]
name = "slide out"
type = "prismatic"
limits = ["0 mm", "300 mm"]
"""


def urdf(joints=7):
    """Return a URDF of turning joints, the last of which slides."""
    text = '<link name="l0"/>'
    for k in range(1, joints + 1):
        kind = "prismatic" if k == joints else "revolute"
        text += (
            f'<link name="l{k}">{BODY}</link><joint name="joint_{k}" type="{kind}"><parent '
            f'link="l{k - 1}"/><child link="l{k}"/>'
        )
        text += (
            f'<origin xyz="0 0 0.2"/><axis xyz="0 {k % 2} {1 - k % 2}"/><limit lower="-1" '
            'upper="1" effort="1" velocity="1"/></joint>'
        )
    return f'<robot name="seven">{text}</robot>'


@pytest.fixture(params=["arm.urdf", "arm.toml"])
def bare(request, tmp_path, monkeypatch):
    """Return the file of an arm of which only shape and masses are known."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / request.param
    path.write_text(urdf() if path.suffix == ".urdf" else NATIVE, encoding="utf-8")
    return path


def test_run_shows_no_figure_of_accuracy_but_those_by_class_of_drive(bare):
    """Workspace, torques, the table and one sentence; of errors, screen, report and result.json
    have only what is assumed by class, and say so.
    """
    found = run_command(app, ["run", str(bare), "--poses", "64", "--out", "out"])
    assert found.exit_code == 0
    answer = " ".join(found.output.split())
    assert "The file itself describes no error source. What is missing: " in answer
    assert NOT_DESCRIBED.partition(", ")[2] not in answer  # the classes have just predicted some
    # a first sidecar is one command away
    assert ("`lostmotion new --from " in found.output) == (bare.suffix == ".urdf")
    said = json.loads((bare.parent / "out" / "result.json").read_text(encoding="utf-8"))
    assert [section["key"] for section in said["sections"]] == [
        "drive_classes",
        "workspace",
        "torques",
        "states",
        "inputs",
        "laws",
    ]
    assert said["states"]["described"] is False
    assert not (bare.parent / "out" / "arrays.nc").exists()
    page = (bare.parent / "out" / "report.html").read_text(encoding="utf-8")
    for text in (found.output, re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)):
        assert "error budget" not in text
        assert not re.search(r"\bAP\b", text)
        words = " ".join(text.split())
        assert (
            words.count("95 % of positions")
            == len(
                re.findall(r"Assumed by class of drive, [a-zRV ]+: expect 95 % of positions", words)
            )
            > 0
        )
    for name in [joint.name for joint in lostmotion.read(bare).moving]:
        assert found.output.count(f'"{name}"') + found.output.count(f"[joints.{name}]") >= 1


@pytest.mark.parametrize(
    "command",
    [["map"], ["target", "--error", "1 mm"], ["iso9283"], ["size", "--target", "1 mm"], ["sweep"]],
)
def test_commands_that_predict_nothing_but_accuracy_refuse(bare, command):
    """One message, exit code 2, and nothing is written."""
    before = sorted(bare.parent.iterdir())
    found = run_command(app, [command[0], str(bare), *command[1:]])
    assert isinstance(found.exception, lostmotion.InputError)
    assert NOT_DESCRIBED in str(found.exception)
    assert "lostmotion study" in str(found.exception)
    assert sorted(bare.parent.iterdir()) == before


def test_functions_refuse_as_the_commands_do(bare):
    """In Python no function returns a figure of accuracy either."""
    arm = lostmotion.read(bare)
    for ask in (
        lambda: lostmotion.study(arm, 8, 2, 2),
        lambda: lostmotion.study(arm, 8, method="analytic"),
        lambda: lostmotion.map(arm),
        lambda: lostmotion.target(arm, error="1 mm"),
        lambda: lostmotion.production_yield(arm, "1 mm"),
        lambda: lostmotion.iso9283(arm),
        lambda: lostmotion.size(arm, target="1 mm"),
    ):
        with pytest.raises(lostmotion.InputError, match=NOT_DESCRIBED):
            ask()


def test_statics_still_stand(bare):
    """Torques need no error source; the sheet says that no accuracy can be predicted."""
    found = run_command(app, ["statics", str(bare), "--poses", "64", "--json"])
    assert found.exit_code == 0
    said = json.loads(found.stdout)
    assert said["states"]["ideal_joints"] == [joint.name for joint in lostmotion.read(bare).moving]
    found = run_command(app, ["statics", str(bare), "--poses", "64", "--out", "statics"])
    assert f"N{NOT_DESCRIBED[1:]}" in " ".join(found.output.split())


def test_the_skeleton_is_a_sidecar_that_is_read(tmp_path):
    """Written beside the URDF as it is printed, it describes every joint; all its values show as
    assumed.
    """
    path = tmp_path / "arm.urdf"
    path.write_text(urdf(), encoding="utf-8")
    arm = lostmotion.read(path)
    lines = skeleton(arm, path, drive_loads(arm))
    (tmp_path / lines.file).write_text(lines.text, encoding="utf-8")
    known = states(lostmotion.read(path))
    assert not known.ideal_joints
    assert {each.states["bearing"] for each in known.joints} == {"assumed"}
    assert "stated" not in {state for each in known.joints for state in each.states.values()}
    assert known.assumed


@pytest.mark.parametrize("name", ["base/j1", "joint 3.0", "ä"])
def test_names_of_joints_are_quoted_where_they_must_be(tmp_path, name):
    """Whatever a joint is called, its table in the skeleton carries that name."""
    joint = RevoluteJoint.model_construct(
        **{**dict(RevoluteJoint(name="A", limits=(-1.0, 1.0))), "name": name}
    )
    plain = Arm(name="x", joints=(RevoluteJoint(name="A", limits=(-1.0, 1.0)),))
    odd = Arm.model_construct(**{**dict(plain), "joints": (joint,)})
    loads = drive_loads(plain)
    text = skeleton(
        odd, tmp_path / "arm.urdf", dataclasses.replace(loads, loads={name: loads.loads["A"]})
    ).text
    import tomllib

    assert list(tomllib.loads(text)["joints"]) == [name]


def test_the_skeleton_adds_to_the_sidecar_that_is_there(tmp_path):
    """Tables that the sidecar has already are not written twice: what belongs in them is a
    comment.
    """
    path, sidecar = tmp_path / "arm.urdf", tmp_path / "arm.toml"
    path.write_text(urdf(3), encoding="utf-8")
    sidecar.write_text(
        (
            '[payload]\nmass = "1 kg"\n[gearboxes.large]\nratio = 50\n[joints.joint_1]\ngearbox = '
            '"large"\n'
        ),
        encoding="utf-8",
    )
    arm = lostmotion.read(path)
    lines = skeleton(arm, path, drive_loads(arm))
    assert lines.file == "arm.toml"
    sidecar.write_text(sidecar.read_text(encoding="utf-8") + lines.text, encoding="utf-8")
    # its lines are a comment: its table is there already
    assert states(lostmotion.read(path)).ideal_joints == ("joint_1",)
    assert "# drive = { torque = " in lines.text


def test_the_skeleton_of_a_toml_says_where_each_line_goes(tmp_path):
    """The tables of parts go to the end; each joint's lines, without their #, go into its own
    table.
    """
    path = tmp_path / "arm.toml"
    path.write_text(NATIVE, encoding="utf-8")
    arm = lostmotion.read(path)
    text = skeleton(arm, path, drive_loads(arm)).text
    head, *joints = re.split(r"^# In \[\[joints\]\] with name = ", text, flags=re.MULTILINE)
    whole = NATIVE
    for each in joints:
        name, _, lines = each.partition(":\n")
        added = "\n".join(line.removeprefix("# ") for line in lines.strip().splitlines())
        whole = whole.replace(f"name = {name}\n", f"name = {name}\n{added}\n")
    path.write_text(NATIVE + text, encoding="utf-8")
    assert not states(lostmotion.read(path)).described  # comments change nothing
    path.write_text(whole + head, encoding="utf-8")
    known = states(lostmotion.read(path))
    assert known.described
    assert not known.ideal_joints


def test_explicit_zeros_are_a_description():
    """Where everything is stated as perfect, the headline says that this predicts nothing, and
    names joints without any statement.
    """
    joints = (
        RevoluteJoint(name="A", limits=(-1.0, 1.0), lumped={"angle": 0.0}, link=Link(length=0.5)),
        PrismaticJoint(name="B", limits=(0.0, 1.0)),
    )
    study = lostmotion.study(Arm(name="x", joints=joints), 8, 4, 2)
    assert study.sampled.group_hist.sum() > 0
    assert study.sheet.verdict.startswith(
        "Every error that is described is zero, and nothing is described for B (taken as perfect)"
    )


def test_zero_is_no_prediction():
    """Where every described error is zero, or none differs from visit to visit, headline and cards
    predict nothing instead of printing 0 µm.
    """
    cases = (
        ({}, "Every error that is described is zero"),
        ({"length_tolerance": 1e-4}, "No described error differs between visits"),
    )
    for tolerance, said in cases:
        link = {"length": 0.5, "rigid": True, **tolerance}
        arm = lostmotion.Arm(
            name="plain",
            joints=(
                {
                    "name": "A",
                    "type": "revolute",
                    "limits": (-1.0, 1.0),
                    "link": link,
                    "lumped": {"angle": 0.0},
                },
            ),
        )
        sheet = lostmotion.study(arm, poses=8, robots=20, visits=3).sheet
        assert said in first_screen(sheet)
        assert " 0 µm" not in sheet.verdict
        assert "0 µm" not in {card.number for card in sheet.cards}
        if not tolerance:
            assert (
                "Every error that is described is zero"
                in lostmotion.study(arm, poses=8, method="analytic").sheet.verdict
            )
