"""`lostmotion new`: templates that run at once, and a first sidecar for a URDF."""

from __future__ import annotations

import re
import shutil
import tomllib
from typing import get_args

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.new.command import Template
from lostmotion.catalogue.gearboxes import find_gearbox
from lostmotion.error_model.provenance import states
from lostmotion.errors import InputError, OutputExistsError
from lostmotion.mechanism.state import state_of
from tests.io.conftest import EXAMPLES
from tests.io.urdfs import arm, link, robot

# Closed chains of many joints take their time.
LARGE = {"linkage-palletiser", "delta", "hexapod"}


@pytest.mark.few_counts
@pytest.mark.parametrize(
    "template",
    [
        pytest.param(each, marks=pytest.mark.slow if each in LARGE else ())
        for each in get_args(Template)
    ],
)
def test_each_template_is_an_arm_with_an_accuracy_and_no_overloaded_drive(template, tmp_path):
    """It is read as it stands, every moving joint is described, nothing is warned of, and a study
    predicts an error of its class.
    """
    path = lostmotion.new("mine", template=template, out=tmp_path / "mine.toml").report()
    arm = lostmotion.read(path)
    assert arm.name == "mine"
    assert states(arm).described
    assert not states(arm).ideal_joints
    assert states(arm).assumed
    study = lostmotion.study(arm, poses=16, method="analytic")
    assert 10e-6 < study.mean.value < 10e-3
    assert study.sheet.warnings == ()


def test_the_name_of_a_file_is_the_name_of_its_arm():
    """Whoever types the ending gets the file of this name, not one with two endings."""
    for named in ("mine", "mine.toml"):
        found = lostmotion.new(named, template="scara")
        assert str(found.path) == "mine.toml"
        assert 'name = "mine"' in found.text
    with pytest.raises(InputError, match="the name of an arm"):
        lostmotion.new(".toml")


def test_the_hobby_arm_needs_about_ten_lines():
    """Presets fill in the rest."""
    assert len(lostmotion.new(template="hobby").text.splitlines()) <= 11


def test_an_existing_file_is_kept_unless_forced(tmp_path):
    """Never overwritten by accident."""
    path = tmp_path / "arm.toml"
    path.write_text("mine", "utf-8")
    with pytest.raises(OutputExistsError, match="--force"):
        lostmotion.new("arm", out=path).report()
    assert path.read_text("utf-8") == "mine"
    lostmotion.new("arm", out=path, force=True).report()
    assert tomllib.loads(path.read_text("utf-8"))["name"] == "arm"


@pytest.mark.usefixtures("unpainted")
def test_the_next_steps_and_the_refusal_of_a_second_study_name_force(tmp_path):
    """Whoever changes the new file and studies it again learns beforehand how the first result is
    replaced, and again where it is refused.
    """
    begun = lostmotion.new("arm", template="scara", out=tmp_path / "arm.toml")
    assert (
        f"`lostmotion study {tmp_path / 'arm.toml'} --force` replaces the first result"
        in begun.sheet.verdict
    )
    study = lostmotion.study(begun.report(), poses=8, method="analytic")
    study.report(tmp_path / "first")
    with pytest.raises(OutputExistsError, match=r"--force.*--out"):
        study.report(tmp_path / "first")
    study.report(tmp_path / "first", force=True)


def test_the_list_names_each_template_and_writes_nothing(tmp_path, monkeypatch):
    """With what it describes."""
    monkeypatch.chdir(tmp_path)
    listed = lostmotion.new(templates=True)
    listed.report()
    (section,) = listed.sheet.sections
    assert [row.label for row in section.rows] == list(get_args(Template))
    assert all(len(str(row.cells[0])) > 20 for row in section.rows)
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def urdf(tmp_path):
    """Copy a URDF without its sidecar, and write its first sidecar."""
    path = tmp_path / "robot.urdf"
    shutil.copy(EXAMPLES / "ur5e.urdf", path)
    assert lostmotion.new(urdf=path).report() == path.with_suffix(".toml")
    return path


def test_the_sidecar_of_a_urdf_describes_each_joint_by_assumed_values(urdf):
    """It is found beside the URDF; gearboxes, bearings and encoders are there, all assumed."""
    known = states(lostmotion.read(urdf))
    assert known.described
    assert known.ideal_joints == ()
    for joint in known.joints:
        assert {joint.states[kind] for kind in ("stiffness", "bearing", "encoder")} == {"assumed"}
        assert "stated" not in joint.states.values()


def test_three_reducers_are_proposed_with_a_margin_over_the_static_load(urdf):
    """Rated for 1.5 times the load of their joint and of all farther out, by an independent set of
    poses; each as a comment.
    """
    arm = lostmotion.read(urdf)
    text = urdf.with_suffix(".toml").read_text("utf-8")
    q = arm.limits[:, 0] + np.random.default_rng(1).random((2000, len(arm.moving))) * np.ptp(
        arm.limits, axis=1
    )
    held = np.abs(state_of(arm, q).torques).max(axis=0)
    for k, joint in enumerate(arm.moving):
        table = text.partition(f"[joints.{joint.name}]")[2].partition("\n[")[0]
        load = float(re.search(r"static load: ([\d.e+-]+)", table)[1])
        assert load >= 0.95 * held[k] - 1e-9
        names = re.findall(r'gearbox = "([^"]+)"', table)
        if not names:
            continue
        assert len(names) == 3
        rated = [find_gearbox(name)[0].figures.part.rated_torque for name in names]
        assert rated == sorted(rated)
        assert rated[0] >= 1.49 * held[k:].max()
        assert all(abs(find_gearbox(name)[1]) >= 30 for name in names)
        assert rated[-1] <= 30.1 * held[k:].max()
    assert text.count("# gearbox = ") >= 6


def test_the_commands_that_follow_replace_a_result_that_is_there(urdf, monkeypatch):
    """A study of the URDF alone has left its folder: the printed command would be refused without
    --force.
    """
    monkeypatch.chdir(urdf.parent)
    (urdf.parent / "robot-accuracy").mkdir()
    verdict = lostmotion.new(urdf=urdf, force=True).sheet.verdict
    assert (
        f"`lostmotion study {urdf} --force` predicts the accuracy. It replaces the result in "
        "robot-accuracy"
    ) in verdict


def test_a_load_that_is_rounding_is_printed_as_zero(urdf):
    """The first axis of the UR5e stands upright and holds nothing."""
    loads = re.findall(r"static load: (\S+) N", urdf.with_suffix(".toml").read_text("utf-8"))
    assert len(loads) == 6
    assert all(load == "0" or float(load) > 1e-6 for load in loads)


def test_a_urdf_leads_to_a_prediction_in_two_commands(urdf):
    """The sidecar as written gives an error between a hundredth of a millimetre and centimetres,
    and says what it rests on.
    """
    study = lostmotion.study(urdf, poses=8, method="analytic")
    assert "assumed" in study.sheet.verdict
    with pytest.raises(OutputExistsError):
        lostmotion.new(urdf=urdf).report()


def test_the_commands_that_follow_name_the_sidecar_where_it_is_not_the_default(urdf, tmp_path):
    """A sidecar written elsewhere would not be found by the URDF's name: the printed commands of
    `new` and of `check` state it.
    """
    elsewhere = tmp_path / "elsewhere.toml"
    made = lostmotion.new(urdf=urdf, out=elsewhere)
    made.report(force=True)
    assert f"`lostmotion study {urdf} --sidecar {elsewhere}`" in made.sheet.verdict
    assert (
        f"`lostmotion study {urdf} --sidecar {elsewhere}`"
        in lostmotion.check(urdf, sidecar=elsewhere).sheet.verdict
    )
    assert "--sidecar" not in lostmotion.new(urdf=urdf, force=True).sheet.verdict


def two_arms(folder):
    """Write a URDF of two arms, between which no reader chooses."""
    path = folder / "two.urdf"
    parts = [
        link("torso"),
        *(
            part
            for side in ("left", "right")
            for part in arm(3, "torso", f"{side}_link", f"{side}_j")[1:]
        ),
    ]
    path.write_text(robot(*parts), encoding="utf-8")
    return path


def test_the_tool_of_a_file_with_two_arms_is_named_by_an_option(tmp_path):
    """Without it the question is asked with the option that answers it; the sidecar that is written
    then states the tip, and is read as it is.
    """
    path = two_arms(tmp_path)
    with pytest.raises(InputError, match=r"(?s)which of 2 arms\?.*--tip left_link3") as asked:
        lostmotion.new(urdf=path)
    assert len(asked.value.problems) == 1
    lostmotion.new(urdf=path, tip="right_link2").report()
    assert 'tip = "right_link2"' in path.with_suffix(".toml").read_text("utf-8")
    assert [joint.name for joint in lostmotion.read(path).moving] == ["right_j1", "right_j2"]
    assert 'tip = "left_link3"' in lostmotion.new(urdf=path, tip="left_link3", force=True).text


@pytest.mark.parametrize(
    ("named", "given", "found"),
    [
        ({"tip": "left_lnk3"}, True, "left_lnk3"),
        ({"tip": "torso"}, True, "no joint that moves"),
        ({"tip": "left_link3"}, False, "of no file"),
    ],
)
def test_a_tool_that_is_none_is_refused_by_the_option(tmp_path, named, given, found):
    """With a link that would do."""
    path = two_arms(tmp_path)
    with pytest.raises(InputError, match=found) as refused:
        lostmotion.new(**named, **({"urdf": path} if given else {}))
    (problem,) = refused.value.problems
    assert "tip" in str(problem)
