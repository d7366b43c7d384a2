"""The declared figures of the error: each is what its definition states."""

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.draws import robot_draws
from lostmotion.error_model.pose_matrix import screws
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of
from lostmotion.parts.joint import RevoluteJoint
from lostmotion.propagation.figures import figures_of

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "figures of the position error by their definitions",
        "NumPy over all samples of the same draws",
        "1e-9 (mean), 0.3 % (percentiles), exact sums against samples 5 %",
        "propagation/figures.py",
    ),
)


@pytest.fixture(scope="module")
def study():
    """Study two joints whose angles are wrong by a constant of each robot."""
    joints = [
        RevoluteJoint(
            name=name, axis=axis, limits=(-1, 1), lumped={"angle": 1e-3, "varies": "robot"}
        )
        for name, axis in (("A", "z"), ("B", "y"))
    ]
    arm = Arm(name="two", joints=joints, tool={"frame": {"xyz": (0.3, 0.1, 0.2)}})
    return lostmotion.study(arm, 16, robots=400, visits=2, seed=4)


def test_figures_are_those_of_all_samples(study):
    """Mean, root mean square and percentiles over all robots and poses, computed by NumPy."""
    matrix = screws(state_of(study.arm, study.poses.q))
    streams = [info.robot for info in matrix.infos]
    drawn = robot_draws(4, streams, 400).transpose(1, 0, 2).reshape(len(streams), -1)[:, :400]
    lengths = np.linalg.norm(matrix.tool[:, 3:] @ drawn, axis=1)
    assert study.mean.value == pytest.approx(lengths.mean(), rel=1e-9)
    assert study.standard_deviation.value == pytest.approx(lengths.std(), rel=1e-6)
    for level, found in ((0.5, study.p50), (0.95, study.p95), (0.99, study.p99)):
        assert found.value == pytest.approx(np.quantile(lengths, level), rel=4e-3)
    assert study.rms.value == pytest.approx(np.sqrt(np.mean(lengths**2)), rel=0.05)
    assert study.rms_robot.value == study.rms.value
    assert study.rms_design.value == study.rms_visit.value == 0


def test_attributes_and_tables_are_the_same_figures(study):
    """`study.p95`, `study.figures`, result.json and the frame have one value each, in SI."""
    said = study.result()["figures"]
    frame = study.frame()
    for key, figure in figures_of(study.errors).items():
        found = getattr(study, key)
        assert found == study.figures[key]
        assert found.unit == figure.unit == frame.unit[key]
        assert frame.value[key] == found.value
        section = said["iso9283"] if key in said["iso9283"] else said["error"]
        if key in section:
            assert (section[key]["value"], section[key]["unit"]) == (found.value, figure.unit)
    assert study.rp == study.figures["rp_iso_p95"]
    assert " mm (" in repr(study.p95) or " µm (" in repr(study.p95)


def test_an_unknown_figure_is_refused_with_the_nearest(study):
    """A slip of the key is named, and no attribute appears from nowhere."""
    with pytest.raises(AttributeError, match="did you mean 'p95'"):
        _ = study.p9s5
    assert not hasattr(study, "_anything")
