"""What the view shows are the figures of the study: at a pose, over the workspace, with remedies,
and with other parts.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion import sample_poses
from lostmotion.error_model.budget import budget
from lostmotion.error_model.remedies import STAGES
from lostmotion.live_view.choices import (
    AS_IN_FILE,
    Choices,
    changed,
    gearbox_names,
    section_names,
)
from lostmotion.live_view.session import LiveArm
from lostmotion.propagation.analytic import Analytic, analytic
from lostmotion.propagation.error_magnitude import LEVELS, TILE
from lostmotion.propagation.pooled import pooled

EXAMPLES = Path(__file__).parents[2] / "examples"
POSES = 256
# the view shows no bounds
ARRAYS = [name for name in Analytic.__dataclass_fields__ if name not in {"levels", "worst", "rss"}]


def equal(found: Analytic, expected: Analytic, row: int) -> None:
    """Check that the figures at one pose are those of a row of others, to 1e-12; uncertainties,
    small differences that processors round, to 1e-10.
    """
    for name in ARRAYS:
        rtol = 1e-10 if name.endswith("uncertainty") else 1e-12
        np.testing.assert_allclose(
            getattr(found, name)[0],
            getattr(expected, name)[row],
            rtol=rtol,
            atol=1e-18,
            err_msg=name,
        )


@pytest.mark.parametrize(
    ("file", "stage"),
    [
        ("z-arm.toml", STAGES[0]),
        ("z-arm.toml", "both"),
        ("ur5e.urdf", STAGES[0]),
        ("ur5e.urdf", "load compensated"),
        ("arm-in-the-sun.toml", "calibrated"),
    ],
)
def test_the_figures_at_a_pose_are_those_of_a_study_without_sampling(file, stage):
    """At poses that the workspace does not hold, every figure equals that of the analytic route
    over the workspace's poses and these.
    """
    arm = lostmotion.read(EXAMPLES / file)
    poses, others = sample_poses(arm, POSES), sample_poses(arm, 4, seed=7).q
    live = LiveArm(arm, poses, stage)
    expected = analytic(arm, np.concatenate([poses.q[:TILE], others]), stage=stage)
    for k, q in enumerate(others):
        equal(live.figures(q).error, expected, TILE + k)


def test_the_figures_are_those_of_the_pose_alone_where_no_draws_are_needed():
    """Mean vector and covariance always; the percentiles too where the error is nearly normal, and
    elsewhere within their stated uncertainties.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    live = LiveArm(arm, sample_poses(arm, POSES))
    others = sample_poses(arm, 16, seed=7).q
    nearly_normal = 0
    for q in others:
        found, alone = live.figures(q), analytic(arm, q[None])
        np.testing.assert_allclose(found.error.bias, alone.bias, rtol=1e-12, atol=1e-18)
        np.testing.assert_allclose(found.error.covariance, alone.covariance, rtol=1e-12, atol=1e-20)
        nearly_normal += int(alone.nearly_normal[0])
        if alone.nearly_normal[0]:
            equal(found.error, alone, 0)
        apart = np.abs(found.error.quantiles - alone.quantiles)
        assert (apart <= found.error.quantiles_uncertainty + alone.quantiles_uncertainty).all()
        assert found.q95 == found.error.quantiles[0, LEVELS.index(0.95)]
    assert 0 < nearly_normal < len(others)


def test_the_budget_and_the_torques_are_those_of_the_pose():
    """The bars show the error budget at the pose, and each drive's torque as a share of its
    rating.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    q = sample_poses(arm, 16, seed=7).q[0]
    found = LiveArm(arm, sample_poses(arm, POSES)).figures(q)
    assert found.costs == list(budget(arm, q[None]).parts)
    np.testing.assert_allclose(found.loads, np.abs(found.torques) / 167.0)
    fixed = {joint.name: joint.model_copy(update={"gearbox": None}) for joint in arm.joints[:1]}
    bare = arm.model_copy(
        update={"joints": tuple(fixed.get(joint.name, joint) for joint in arm.joints)}
    )
    assert np.isnan(LiveArm(bare, sample_poses(arm, POSES)).figures(q).loads).tolist() == [
        True,
        False,
        False,
        False,
        False,
    ]


@pytest.mark.parametrize("stage", STAGES[:3])
def test_the_workspace_is_that_of_a_study_without_sampling(stage):
    """The colours, and the percentile over all poses, are those of the analytic route over the same
    poses, computed part by part.
    """
    arm = lostmotion.read(EXAMPLES / "ur5e.urdf")
    poses = sample_poses(arm, POSES)
    *parts, found = LiveArm(arm, poses, stage).workspace()
    assert parts == [None] * poses.replicates  # so few poses that a set of them is one part
    expected = analytic(arm, poses, stage=stage)
    np.testing.assert_allclose(found.q95, expected.quantiles[:, LEVELS.index(0.95)], rtol=1e-12)
    np.testing.assert_allclose(found.points, lostmotion.state_of(arm, poses.q).frames[-1, :, :3, 3])
    assert found.whole == pooled(arm, poses, expected, stage=stage).quantiles[LEVELS.index(0.95)]


def test_each_switch_removes_its_own_errors():
    """A controller that knows the load leaves no mean error; calibration leaves the mean error and
    makes the scatter smaller.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    poses = sample_poses(arm, POSES)
    q = poses.q[3]
    stages = {
        choices.stage: choices
        for on in (0, 1)
        for by in (0, 1)
        for choices in [Choices(5.0, compensated=bool(on), calibrated=bool(by))]
    }
    assert set(stages) == set(STAGES[:4])
    assert stages["both"].compensated
    assert stages["both"].calibrated
    error = {stage: LiveArm(arm, poses, stage).figures(q).error for stage in stages}
    assert not error["load compensated"].bias.any()
    np.testing.assert_array_equal(error["calibrated"].bias, error[STAGES[0]].bias)
    scatter = {stage: float(np.trace(each.covariance[0])) for stage, each in error.items()}
    assert scatter["both"] == pytest.approx(scatter["calibrated"])
    assert scatter["calibrated"] < scatter["load compensated"] == pytest.approx(scatter[STAGES[0]])


def in_file(tmp_path: Path, **changes: str) -> lostmotion.Arm:
    """Return the five-joint example with pieces of its text replaced."""
    text = (EXAMPLES / "z-arm.toml").read_text("utf-8")
    for old, new in changes.values():
        assert text.count(old) == 1
        text = text.replace(old, new)
    (tmp_path / "arm.toml").write_text(text, "utf-8")
    return lostmotion.read(tmp_path / "arm.toml")


def same_error(one: lostmotion.Arm, other: lostmotion.Arm) -> None:
    """Check that two arms have the same error, to 1e-12, at a few poses."""
    poses = sample_poses(one, TILE)
    here, there = analytic(one, poses), analytic(other, poses)
    for name in ("bias", "covariance", "mean"):
        np.testing.assert_allclose(
            getattr(here, name), getattr(there, name), rtol=1e-12, atol=1e-20
        )


def test_another_gearbox_is_that_of_the_catalogue(tmp_path):
    """A reducer chosen in the view changes the error as its name in the arm file does."""
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    joint = (
        '120 deg"]                # q1 from 200 down to 60 deg\nmass = "4 kg"\nassumed = '
        '["limits", "mass"]\ngearbox = '
    )
    written = in_file(tmp_path, at=(f'{joint}"cycloidal"', f'{joint}"RV-80E-121"'))
    chosen = changed(arm, Choices(arm.payload.mass, gearboxes={"A": "RV-80E-121", "B": AS_IN_FILE}))
    same_error(chosen, written)
    assert not np.allclose(
        analytic(chosen, sample_poses(arm, TILE)).mean, analytic(arm, sample_poses(arm, TILE)).mean
    )


def test_another_section_and_payload_are_those_of_the_file(tmp_path):
    """The stiffness of a link, its own weight, and the load on all joints follow the choice."""
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    large = (
        '[sections.small]\nkind = "tube"\nouter = "60 mm"\nwall = "3 mm"',
        '[sections.small]\nkind = "tube"\nouter = "80 mm"\nwall = "4 mm"',
    )
    same_error(
        changed(arm, Choices(arm.payload.mass, sections={"roll": "tube 80 x 4 mm"})),
        in_file(tmp_path, at=large),
    )
    beside = (
        'link = { length = "400 mm ± 50 µm", section = "medium"',
        'link = { length = "400 mm ± 50 µm", section = "large"',
    )
    same_error(
        changed(arm, Choices(arm.payload.mass, sections={"B": "that of A"})),
        in_file(tmp_path, at=beside),
    )
    # Friction that the file does not state follows the payload of the file: the drives stay the
    # same. This arm has no such friction.
    ur5e = lostmotion.read(EXAMPLES / "ur5e.urdf")
    same_error(
        changed(ur5e, Choices(9.0)),
        ur5e.model_copy(update={"payload": ur5e.payload.model_copy(update={"mass": 9.0})}),
    )


def test_the_arm_itself_is_kept_without_changes():
    """Choices equal to the file give the arm of the file."""
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    assert changed(arm, Choices(arm.payload.mass, sections={"A": AS_IN_FILE})) is arm


def test_every_offer_can_be_taken():
    """Each reducer of the catalogue, and each section, makes a valid part of a turning joint;
    slides and links of no length have none.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    joint = arm.joints[1]
    names = gearbox_names(joint)
    assert "RV-80E-121" in names
    assert len(names) > 50
    for name in names:
        assert changed(arm, Choices(5.0, gearboxes={"A": name})).joints[1].gearbox.model == name
    for name in section_names(arm, joint):
        assert changed(arm, Choices(5.0, sections={"A": name})).joints[1].link.section is not None
    assert section_names(arm, arm.joints[3]) == []
    slide = lostmotion.Arm.model_validate(
        {"name": "s", "joints": [{"type": "prismatic", "name": "x", "limits": (0.0, 1.0)}]}
    )
    assert gearbox_names(slide.joints[0]) == []
