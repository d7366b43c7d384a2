"""The temperature of an arm as error terms: a scaled arm, one draw for all links, and the same
figures from every route.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lostmotion
from lostmotion.error_model.pose_matrix import pose_matrix, screws
from lostmotion.error_model.poses import Poses
from lostmotion.error_model.provenance import states
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of, tool_points
from lostmotion.mechanism.tool import Tool
from lostmotion.mechanism.warm_up import WarmUp, drift, growth
from lostmotion.parts.environment import Environment
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.reporting.not_counted import NOT_COUNTED
from lostmotion.sizing.error_cache import BIAS, COVARIANCE, ErrorCache

Z_ARM, URDF = "examples/z-arm.toml", "examples/ur5e.urdf"


def in_heat(arm: Arm, temperature: str | None, **fields: object) -> Arm:
    """Return the arm at a temperature."""
    return arm.model_copy(update={"environment": Environment(temperature=temperature, **fields)})


def some_poses(arm: Arm, count: int = 6) -> np.ndarray:
    """Return poses anywhere between the limits of the joints."""
    rng = np.random.default_rng(5)
    return rng.uniform(arm.limits[:, 0], arm.limits[:, 1], (count, len(arm.moving)))


def of_links(arm: Arm, q: np.ndarray) -> np.ndarray:
    """Return the sum of the vectors from each joint to the far end of its link (pose, 3), for links
    between base and tool.
    """
    at, tree = state_of(arm, q).frames, arm.tree
    tips = [unit.tip for unit in tree.joints if unit.tip in tree.tool_path]
    return np.asarray(
        sum(at[tip, :, :3, 3] - at[tree.places[tip].parent, :, :3, 3] for tip in tips)
    )


@pytest.fixture(scope="module")
def arm() -> Arm:
    """Return the arm of the paper, all links of which are aluminium."""
    return lostmotion.read(Z_ARM)


@given(temperature=st.floats(-20, 60))
@settings(max_examples=10, deadline=None)
def test_an_arm_of_one_material_grows_in_proportion(arm: Arm, temperature: float):
    """The tool of an arm of aluminium moves by expansion x rise x the sum of its link vectors, and
    does not turn.
    """
    q = some_poses(arm)
    moved = (
        screws(state_of(in_heat(arm, f"{temperature} °C"), q)).bias - screws(state_of(arm, q)).bias
    )
    np.testing.assert_allclose(
        moved[:, 3:], 23e-6 * (temperature - 20) * of_links(arm, q), rtol=1e-9, atol=1e-15
    )
    np.testing.assert_allclose(moved[:, :3], 0, atol=1e-15)


@pytest.mark.parametrize("seed", range(5))
def test_growth_is_that_of_an_arm_with_longer_links(seed: int):
    """Each link with an expansion of its own: the tool moves to where forward kinematics of the arm
    with its grown lengths has it.
    """
    rng = np.random.default_rng(seed)
    lengths, expansions, rise = (
        rng.uniform(0.1, 0.8, 5),
        rng.uniform(-1e-6, 110e-6, 5),
        rng.uniform(-40, 60),
    )

    def built(by: np.ndarray, **fields: object) -> Arm:
        links = [
            {"length": length, "direction": axis, "expansion": a}
            for length, axis, a in zip(by, "xyzxz", expansions, strict=True)
        ]
        joints = [
            {
                "name": f"J{k}",
                "type": "revolute",
                "axis": "zyxzy"[k],
                "limits": (-3, 3),
                "link": link,
            }
            for k, link in enumerate(links)
        ]
        return Arm.model_validate({"name": "grown", "joints": joints, **fields})

    hot = built(lengths, environment={"temperature": 293.15 + rise})
    q = some_poses(hot)
    moved = tool_points(built(lengths * (1 + expansions * rise)), q) - tool_points(hot, q)
    np.testing.assert_allclose(screws(state_of(hot, q)).bias[:, 3:], moved, rtol=1e-9, atol=1e-14)


def test_the_reference_temperature_is_that_of_the_drawing(arm: Arm):
    """At the reference temperature nothing has grown; above another one the arm has grown by the
    difference alone.
    """
    q = some_poses(arm)
    at_rest = screws(state_of(arm, q)).bias
    np.testing.assert_array_equal(screws(state_of(in_heat(arm, "20 °C"), q)).bias, at_rest)
    moved, other = (
        screws(state_of(in_heat(arm, "30 °C", reference_temperature=t), q)).bias - at_rest
        for t in ("20 °C", "298.15 K")
    )
    np.testing.assert_allclose(other, moved / 2, rtol=1e-9, atol=1e-16)


@pytest.mark.parametrize("varies", ["robot", "visit"])
def test_all_links_share_one_temperature(arm: Arm, varies: str):
    """The ± of the temperature is one draw for the whole arm: the variance is that of the whole
    growth, not the sum of those of the links.
    """
    q = some_poses(arm)
    hot = screws(state_of(in_heat(arm, "20 °C ± 6 K (uniform)", temperature_varies=varies), q))
    (found,) = [
        members
        for draws, members in hot.groups.items()
        if draws and draws[0][0] == (varies, "environment.temperature")
    ]
    shift = hot.tool[:, 3:, found].sum(axis=2)
    np.testing.assert_allclose(
        shift, 23e-6 * 6 / np.sqrt(3) * of_links(arm, q), rtol=1e-9, atol=1e-15
    )
    more = hot.merged.squares[
        [
            k
            for k, info in enumerate(hot.merged.infos)
            if info.draws and info.draws[0][0][1].startswith("environment")
        ]
    ]
    np.testing.assert_allclose(more.sum(axis=0), (shift**2).sum(axis=1), rtol=1e-12)


@pytest.mark.parametrize("varies", ["robot", "visit"])
def test_the_sizing_cache_and_the_pose_matrix_agree(arm: Arm, varies: str):
    """Bias and covariance of an arm at a temperature ±, also after another temperature was asked of
    the same cache.
    """
    q = some_poses(arm, 20)
    cache = ErrorCache(arm, q)
    for temperature in ("35 °C ± 6 K", "10 °C", None, "35 °C ± 3 K"):
        hot = in_heat(arm, temperature, temperature_varies=varies)
        sums, matrix = cache.of(hot), screws(state_of(hot, q))
        np.testing.assert_allclose(sums[BIAS].T, matrix.bias[:, 3:], rtol=1e-9, atol=1e-16)
        drawn = matrix.merged.tool[:, 3:, matrix.merged.columns("robot", "visit", "robot x visit")]
        covariance = drawn @ drawn.transpose(0, 2, 1)
        pairs = np.stack(
            [covariance[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))]
        )
        np.testing.assert_allclose(sums[COVARIANCE], pairs, rtol=1e-9, atol=1e-9 * covariance.max())


@pytest.mark.parametrize("varies", ["robot", "visit"])
def test_sampled_and_summed_errors_agree(arm: Arm, varies: str):
    """The mean-square error of simulated robots at 40 °C ± 15 K is that of the pose matrix; the
    exact composition differs by far less.
    """
    hot, q = in_heat(arm, "40 °C ± 15 K", temperature_varies=varies), some_poses(arm, 16)
    found = run(hot, Poses(q, "given"), robots=4000, visits=4, seed=1)
    merged = pose_matrix(hot, q).merged
    summed = (merged.bias[:, 3:] ** 2).sum() + merged.squares.sum(axis=1)[
        merged.columns("robot", "visit", "robot x visit")
    ].sum()
    assert found.per_pose[:, kernel.MEAN_SQUARE].sum() == pytest.approx(summed, rel=0.02)
    assert found.tally.total == pytest.approx(summed, rel=1e-9)
    assert found.exact.largest < 0.02 * np.sqrt(summed / len(q))


def test_a_visit_temperature_is_repeatability_and_a_robot_temperature_is_not(arm: Arm):
    """A temperature that differs from visit to visit scatters the visits of a robot; one that
    differs from robot to robot leaves RP unchanged.
    """
    q = Poses(some_poses(arm), "given")
    found = {
        varies: run(
            in_heat(arm, "20 °C ± 20 K", temperature_varies=varies),
            q,
            robots=300,
            visits=10,
            seed=1,
        )
        for varies in ("robot", "visit")
    }
    cold = run(arm, q, robots=300, visits=10, seed=1)
    np.testing.assert_allclose(
        found["robot"].repeatability[:, 0], cold.repeatability[:, 0], rtol=1e-7
    )
    assert (found["visit"].repeatability[:, 0] > 1.1 * cold.repeatability[:, 0]).all()


def test_an_arm_without_a_temperature_has_no_thermal_term(arm: Arm):
    """Nothing is added where no temperature is stated, and it is listed among what is not
    counted.
    """
    assert not any(
        word in placed.name for placed in arm.terms for word in ("thermal", "temperature")
    )
    assert not any("temperature" in remark for remark in arm.remarks)
    assert "thermal expansion where no temperature is stated" in NOT_COUNTED


def test_what_expands_is_stated_in_the_remarks():
    """The remark names the links that expand and those without a stated expansion; a catalogue's
    expansion is an assumption.
    """
    arm = lostmotion.read(Z_ARM)
    hot = in_heat(arm, "35 °C ± 5 K")
    assert "temperature +15 K (± 5 K from robot to robot)" in hot.remarks[-1]
    assert "links of O, A, B, roll. Not counted: expansion of base" in hot.remarks[-1]
    assumed = {value.key for value in states(hot).assumed}
    assert {"expansion", "reference_temperature"} <= assumed
    assert not {"expansion", "reference_temperature"} & {value.key for value in states(arm).assumed}
    joint = {"name": "A", "type": "revolute", "limits": (-1, 1), "link": {"length": 1.0}}
    rigid = Arm.model_validate(
        {"name": "rigid", "joints": [joint], "environment": {"temperature": "35 °C"}}
    )
    assert (
        "links of no joint. Not counted: expansion of links of A (expansion not stated), base"
        in rigid.remarks[-1]
    )


def test_an_arm_that_only_expands_is_described():
    """A rigid and exact arm whose link expands has an accuracy: 23 µm for 1 m of aluminium and 1
    K.
    """
    joint = {
        "name": "A",
        "type": "revolute",
        "limits": (-1, 1),
        "link": {"length": 1.0, "expansion": 23e-6},
    }
    rigid = Arm.model_validate({"name": "rigid", "joints": [joint]})
    assert not states(rigid).described
    assert states(in_heat(rigid, "21 °C")).described
    study = lostmotion.study(in_heat(rigid, "21 °C"), 4, robots=20, visits=2)
    np.testing.assert_allclose(study.sampled.per_pose[:, 0], 23e-6, rtol=1e-9)


@pytest.mark.parametrize("file", [Z_ARM, URDF, "examples/arm-from-drawings.toml"])
def test_warm_up_drift_is_the_growth_of_the_links(file: str):
    """The tool drifts by expansion x rise x the sum of the link vectors, at every pose, whatever
    the materials and the temperature stated.
    """
    arm = lostmotion.read(file)
    for stated in (arm, in_heat(arm, "35 °C ± 5 K")):
        for q in some_poses(arm, 3):
            found = growth(stated, q, WarmUp(25.0, expansion=17e-6))
            np.testing.assert_allclose(
                found, 17e-6 * 25 * of_links(arm, q[None])[0], rtol=1e-12, atol=1e-18
            )


def test_warm_up_drift_settles_at_the_full_growth(arm: Arm):
    """After eight hours with a time constant of an hour the shift is the whole growth but for
    exp(-8).
    """
    q = some_poses(arm, 1)[0]
    warm_up = WarmUp(-300.0)
    found = drift(arm, q, np.zeros((1, 3)), warm_up)
    np.testing.assert_allclose(
        found.shift[-1], (1 - np.exp(-8)) * growth(arm, q, warm_up), rtol=1e-12
    )
    assert found.largest[0] == pytest.approx(np.linalg.norm(found.shift[-1]), rel=1e-12)


def test_what_is_beside_the_tool_does_not_drift(arm: Arm):
    """The length of the tool itself does not expand: its own temperature is not that of the arm."""
    q = some_poses(arm, 1)[0]
    longer = arm.model_copy(update={"tool": Tool(frame={"xyz": (0.0, 0.0, 1.0)})})
    np.testing.assert_allclose(
        growth(longer, q, WarmUp(25.0)), growth(arm, q, WarmUp(25.0)), rtol=1e-12, atol=1e-18
    )
