"""The declared figures of the error: each is what its definition states."""

import re
from functools import cached_property
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.result import Result
from lostmotion.error_model.differences import deviation_difference
from lostmotion.error_model.draws import robot_draws
from lostmotion.error_model.error_bins import bin_edges
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.mechanism.arm import Arm
from lostmotion.parts.joint import RevoluteJoint
from lostmotion.propagation.figures import figures_of

SOURCE = Path(lostmotion.__file__).parent
# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "figures of the position error by their definitions",
        "NumPy over all samples of the same draws",
        "1e-9 (mean), 0.3 % (percentiles), exact sums against samples 5 %",
        "propagation/figures.py propagation/error_samples.py",
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
    matrix = pose_matrix(study.arm, study.poses.q)
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


def test_a_bound_says_so_wherever_it_is_read(study, z_arm_study):
    """Of arms that lack kinds of error, the scatter of friction alone, and nothing: in Python and
    in the frame as in result.json; the levels of chance have no sign there either.
    """
    turning = {"ratio": 50, "backlash": "2 arcmin ± 1 arcmin"}
    joint = {"name": "A", "limits": ["-60 deg", "60 deg"], "gearbox": turning}
    tool = {"frame": {"xyz": ["300 mm", "0 mm", "0 mm"]}}
    part = lostmotion.read({"name": "part", "joints": [joint | {"type": "revolute"}], "tool": tool})
    lacking = lostmotion.study(part, 16, robots=16, visits=2)
    for of, error, repeats in (
        (lacking, "lower", "lower"),
        (z_arm_study, "", "lower"),
        (study, "", ""),
    ):
        assert (of.p95.bound, of.rp.bound) == (error, repeats)
        said, frame = of.result()["figures"], of.frame()
        for key, figure in figures_of(of.errors).items():
            assert frame.bound[key] == of.figures[key].bound
            if figure.group != "levels":
                assert of.figures[key].bound == said[figure.group][key].get("bound", ""), key
    assert repr(z_arm_study.rp).startswith("≥ ")


def test_an_unknown_figure_is_refused_with_the_nearest(study):
    """A slip of the key is named, and no attribute appears from nowhere."""
    with pytest.raises(AttributeError, match="did you mean 'p95'"):
        _ = study.p9s5
    assert not hasattr(study, "_anything")


def test_a_study_without_sampling_has_the_same_figures(study):
    """By key, in SI, from the same declarations; it has no AP, RP and rotation."""
    summed = lostmotion.study(study.arm, 16, method="analytic", seed=4)
    assert set(summed.figures) >= {"mean", "standard_deviation", "rms", "p50", "p95", "rms_robot"}
    assert summed.rms.value == study.rms.value
    assert summed.p95.value == pytest.approx(study.p95.value, rel=0.1)
    assert summed.p95.low < summed.p95.value < summed.p95.high
    assert summed.frame().unit["p95"] == "m"
    said = summed.result()["figures"]["analytic"]
    for key in ("mean", "standard_deviation", "rms", "p50", "p95", "p99"):
        assert said[key]["value"] == summed.figures[key].value
    assert not hasattr(summed, "ap")


def test_the_difference_of_standard_deviations_is_that_of_the_samples():
    """Its value is the difference of both; its interval contains zero for two halves of one
    population, in about 95 of 100 cases, and not for the double.
    """
    rng = np.random.default_rng(8)
    edges, seen = bin_edges(), 0
    for _ in range(100):
        arms = [rng.rayleigh(1e-4, (20, 8, 100)) for _ in range(2)]
        hists = [
            [
                np.array([np.histogram(each, edges)[0] for each in members])
                for members in (arm, arm.swapaxes(0, 1))
            ]
            for arm in arms
        ]
        means, values = ([float(of(arm)) for arm in arms] for of in (np.mean, np.std))
        found = deviation_difference(*map(tuple, hists), tuple(means), tuple(values))
        assert found.value == pytest.approx(values[1] - values[0])
        seen += found.low <= 0 <= found.high
    assert seen >= 88
    doubled = tuple(
        np.array([np.histogram(2 * each, edges)[0] for each in members])
        for members in (arms[0], arms[0].swapaxes(0, 1))
    )
    grown = deviation_difference(
        tuple(hists[0]), doubled, (means[0], 2 * means[0]), (values[0], 2 * values[0])
    )
    assert grown.low > 0
    assert grown.low < values[0] < grown.high


def test_every_result_has_figures_and_a_table_of_them(study):
    """By the keys of result.json, in its unit, without those that are words."""
    assert all(
        isinstance(each.__dict__.get("figures", Result.figures), property | cached_property)
        for kind in (Result, *Result.__subclasses__())
        for each in kind.__mro__
    )
    found = Result.figures.fget(study)
    said = study.result()["figures"]
    assert found["error.p95"] == study.p95
    assert found["error.p95"].unit == said["error"]["p95"]["unit"] == "m"
    of_budget = {key: each for key, each in found.items() if key.startswith("budget.")}
    assert len(of_budget) == sum(len(row) for row in said["budget"].values())
    table = Result.frame(study)
    assert list(table.index) == list(found)
    assert table.value["error.p95"] == study.p95.value


# Error of each stage of the remedies, and of any share for a target: from samples of their own.
OTHER_SAMPLES = {"propagation/montecarlo/waterfall.py", "propagation/factor_metrics.py"}


def test_figures_are_declared_once():
    """No other file of the source estimates a list of figures, and none finds one by its label."""
    source = {
        path.relative_to(SOURCE).as_posix(): path.read_text("utf-8")
        for path in SOURCE.rglob("*.py")
    }
    assert {name for name, text in source.items() if re.search(r"\bfind_row\b", text)} == set()
    listed = re.compile(
        r"\bpooled_(mean|quantile|robots_quantile)\(.{0,400}\bpooled_(quantile|robots_quantile)\(",
        re.DOTALL,
    )
    found = {name for name, text in source.items() if listed.search(text)}
    own = {"propagation/figures.py", "propagation/error_samples.py"}
    assert found - own == OTHER_SAMPLES
