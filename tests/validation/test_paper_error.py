"""The paper's error model: lostmotion's engine against the corrected formulas in plain NumPy
(examples/paper), and the misprints by name.
"""

import importlib.util
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.mechanism.state import state_of

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "the paper's Monte Carlo, eqs. (8), (9)",
        "independent exact kinematics",
        "0.5 % mean, 1 % of the 95th percentile",
    ),
)

PAPER = Path(__file__).parents[2] / "examples" / "paper"
ARM_FILE = PAPER / "z-arm-lumped.toml"
POSES, ROBOTS = 2000, 512


def _by_path(name):
    spec = importlib.util.spec_from_file_location(f"paper_example_{name}", PAPER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


method = _by_path("paper_method")
Z_ARM = method.ZArm()


def _arm(*, offsets=True):
    if offsets:
        return lostmotion.read(ARM_FILE)
    described = tomllib.loads(ARM_FILE.read_text("utf-8"))
    for joint in described["joints"]:
        joint["lumped"]["offset"] = "0 µm"
    return lostmotion.Arm.model_validate(described)


@pytest.fixture(scope="module")
def poses():
    """The paper's poses: normal around mid-range."""
    return method.workspace_poses(Z_ARM, np.random.default_rng(7), POSES)


@pytest.fixture(scope="module")
def draws():
    """Angle errors for every pose and robot; poses repeat in the order of `np.repeat`."""
    return method.angle_errors(
        np.random.default_rng(8), POSES * ROBOTS, method.JOINT_ARCMIN * method.ARCMIN
    )


def _figures(study):
    section = next(s for s in study.result()["sections"] if s["key"] == "error")
    values = {row["label"]: row["figures"][0] for row in section["rows"]}
    return values["mean"]["value"], values["95th percentile"]["value"]


def _study(arm, q):
    return lostmotion.study(arm, poses=q, robots=ROBOTS, visits=1, seed=3)


def test_the_arm_file_and_the_formulas_put_the_tool_at_the_same_point(poses):
    """Eq. (1) with sines in Z is the kinematics of the TOML arm, its interior angles taken as they
    are.
    """
    assert lostmotion.state_of(_arm(), poses).frames[-1, :, :3, 3] == pytest.approx(
        method.position(Z_ARM, poses), abs=1e-12
    )
    assert _arm().limits == pytest.approx(Z_ARM.ranges)


def test_the_engine_agrees_with_exact_eq_8_without_offsets(poses, draws):
    """Same poses, draws of their own, 1 million samples: the mean within 0.5 %, the 95 % error
    within 1 %.
    """
    q = np.repeat(poses, ROBOTS, axis=0)
    nothing = np.zeros((len(q), 4))
    exact = method.deviation(method.displaced(Z_ARM, q, draws, nothing), method.position(Z_ARM, q))
    mean, p95 = _figures(_study(_arm(offsets=False), poses))
    assert mean == pytest.approx(exact.mean(), rel=0.005)
    assert p95 == pytest.approx(np.quantile(exact, 0.95), rel=0.01)


def test_the_engine_agrees_with_exact_eq_8_with_offsets_across_the_axes(poses, draws):
    """The engine moves a joint across its axis; eq. (8) with its offsets placed so gives the same
    figures.
    """
    q = np.repeat(poses, ROBOTS, axis=0)
    offsets = np.random.default_rng(9).uniform(-method.OFFSET, method.OFFSET, (len(q), 4, 2))
    exact = method.deviation(
        method.displaced_across_axes(Z_ARM, q, draws, offsets), method.position(Z_ARM, q)
    )
    mean, p95 = _figures(_study(_arm(), poses))
    assert mean == pytest.approx(exact.mean(), rel=0.005)
    assert p95 == pytest.approx(np.quantile(exact, 0.95), rel=0.01)


def test_offsets_along_the_chassis_or_across_the_axes_differ_by_less_than_a_percent():
    """Where eq. (8) puts the offsets matters little: they are small beside the angles."""
    chassis, across = (
        method.deviations(Z_ARM, 400_000, 5),
        method.deviations_across_axes(Z_ARM, 400_000, 5),
    )
    assert across.mean() == pytest.approx(chassis.mean(), rel=0.01)
    assert across.mean() > chassis.mean()
    assert np.quantile(across, 0.95) == pytest.approx(np.quantile(chassis, 0.95), rel=0.01)


def test_the_engine_draws_the_papers_poses():
    """With poses of lostmotion's own "normal" law the whole Monte Carlo agrees, workspace
    included.
    """
    study = lostmotion.study(
        _arm(offsets=False), poses=16_000, robots=64, visits=1, seed=11, pose_law="normal"
    )
    exact = method.deviations(Z_ARM, 1_000_000, 12, offset=0.0)
    mean, p95 = _figures(study)
    assert mean == pytest.approx(exact.mean(), rel=0.005)
    assert p95 == pytest.approx(np.quantile(exact, 0.95), rel=0.01)


def test_the_error_is_first_order_at_the_papers_sizes(poses):
    """Exact composition and the engine's sum differ by less than 0.2 % of the 95 % error."""
    study = _study(_arm(), poses[:512])
    assert study.sampled.exact.largest < 0.002 * _figures(study)[1]


def test_from_zero_to_maximum_is_half_a_maximum_of_bias():
    """Mean max/2, deviation max/6 less the cut, nothing outside 0..max; in the engine's terms and
    in the draws.
    """
    largest = method.JOINT_ARCMIN * method.ARCMIN
    drawn = method.angle_errors(np.random.default_rng(1), 200_000, largest)
    assert drawn.min() >= 0
    assert drawn.max() <= largest
    assert drawn.mean() == pytest.approx(largest / 2, rel=1e-3)
    assert drawn.std() == pytest.approx(0.98658 * largest / 6, rel=3e-3)
    matrix = lostmotion.screws(lostmotion.state_of(_arm(), np.radians([[0.0, 90.0, 90.0, 180.0]])))
    names = [info.name for info in matrix.infos]
    mean = matrix.local[0, 1, names.index("joints.A.lumped.mean angle")]
    angle = names.index("joints.A.lumped.angle")
    assert mean == pytest.approx(largest / 2)
    assert matrix.local[0, 1, angle] == pytest.approx(drawn.std(), rel=3e-3)
    assert matrix.local[0, 1, angle] * matrix.infos[angle].bound == pytest.approx(largest / 2)


def test_eq_1_as_printed_puts_every_point_on_a_cone(poses):
    """With cosines in Z the height above O equals the distance from the vertical axis; with sines
    the arm has a workspace.
    """
    for reading, cone in (("printed", True), ("corrected", False)):
        point = method.position(Z_ARM, poses, reading)
        out, up = np.hypot(point[:, 0] - Z_ARM.s, point[:, 1]), point[:, 2] - Z_ARM.height
        assert np.allclose(out, np.abs(up), atol=1e-12) == cone


def test_eq_8_as_printed_turns_y_by_the_wrong_error():
    """An error of the base alone leaves the printed Y where it was, and one of A alone moves it as
    if the base had turned.
    """
    q, nothing = np.radians([[40.0, 100.0, 110.0, 170.0]]), np.zeros((1, 4))
    error = 1e-3
    of_o, of_a = np.array([[error, 0, 0, 0]]), np.array([[0, error, 0, 0]])
    printed, corrected = method.position(Z_ARM, q, "printed"), method.position(Z_ARM, q)
    assert method.displaced(Z_ARM, q, of_o, nothing, "printed")[0, 1] == pytest.approx(
        printed[0, 1], abs=1e-15
    )
    assert method.displaced(Z_ARM, q, of_o, nothing)[0, 1] - corrected[0, 1] == pytest.approx(
        error * (corrected[0, 0] - Z_ARM.s), rel=1e-3
    )
    as_printed = method.displaced(Z_ARM, q, of_a, nothing, "printed")[0, 1]
    as_corrected = method.displaced(Z_ARM, q, of_a, nothing)[0, 1]
    assert as_printed - as_corrected == pytest.approx(error * (corrected[0, 0] - Z_ARM.s), rel=5e-3)


def test_the_misprints_change_the_deviations():
    """Taken letter by letter the method gives a mean 4 % too small and a 95 % error 10 % too
    large.
    """
    printed, corrected = (
        method.deviations(Z_ARM, 400_000, 5, reading) for reading in ("printed", "corrected")
    )
    assert printed.mean() / corrected.mean() == pytest.approx(0.957, abs=0.01)
    assert np.quantile(printed, 0.95) / np.quantile(corrected, 0.95) == pytest.approx(
        1.103, abs=0.01
    )


def test_the_offsets_of_eq_8_are_one_value_in_x_and_y_and_three_in_z():
    """Delta o moves D along the chassis' diagonal, Delta a, b and c add up in height."""
    q = np.radians([[40.0, 100.0, 110.0, 170.0]])
    moved = method.displaced(
        Z_ARM, q, np.zeros((1, 4)), np.array([[10e-6, 1e-6, 2e-6, 4e-6]])
    ) - method.position(Z_ARM, q)
    assert moved[0] == pytest.approx([10e-6, 10e-6, 7e-6], abs=1e-15)


def test_the_static_moment_is_the_worst_over_tilts(poses):
    """Eq. (3) with its misprints corrected is what gravity can ask of A at most; eq. (2)'s Mx is
    what it asks on a level chassis.
    """
    mx, _, total = method.static_moment(Z_ARM, method.Weights(), poses)
    assert lostmotion.worst_torques_over_tilts(lostmotion.state_of(_arm(), poses))[
        :, 1
    ] == pytest.approx(total, rel=1e-12)
    assert np.abs(state_of(_arm(), poses).torques[:, 1]) == pytest.approx(np.abs(mx), abs=1e-10)


def test_eq_2_as_printed_counts_the_weight_at_d_twice(poses):
    """Printed less corrected: m_D over the whole arm in place of m_B h2, and m2 at h2 + h3 + h4/2
    in place of h2/2.
    """
    w = method.Weights()
    (h2, h3, h4), (z2, _, _) = method.projections(Z_ARM, poses)
    printed, corrected = (
        method.static_moment(Z_ARM, w, poses, reading) for reading in ("printed", "corrected")
    )
    assert printed[0] - corrected[0] == pytest.approx(
        w.node_d * (h2 + h3 + h4) - w.node_b * h2 + w.link2 * (h2 / 2 + h3 + h4 / 2), abs=1e-10
    )
    assert printed[1] - corrected[1] == pytest.approx((w.node_d - w.node_b) * z2, abs=1e-10)


def test_the_slope_of_a_link_is_the_cantilevers():
    """A link between level A, B and C: the engine's beam turns by F l^2/2 + M l + W l^2/6 over E I,
    and (6) as printed is no angle at all.
    """
    described = tomllib.loads(ARM_FILE.read_text("utf-8"))
    area, inertia, young = 1e-3, 1e-6, 70e9
    section = {
        "kind": "custom",
        "area": area,
        "i_y": inertia,
        "i_z": inertia,
        "torsion": 2 * inertia,
        "shear_y": 1.0,
        "shear_z": 1.0,
    }
    link = described["joints"][2]["link"]
    del link["rigid"]
    link |= {"section": section, "material": {"young": young, "poisson": 0.3, "density": 2700.0}}
    q = np.radians([[0.0, 180.0, 135.0, 180.0]])
    matrix = lostmotion.screws(lostmotion.state_of(lostmotion.Arm.model_validate(described), q))
    bent = sum(
        matrix.local[0, :, k]
        for k, info in enumerate(matrix.infos)
        if info.owner == "joints.B.link"
    )
    w, (length, next_length) = method.Weights(), Z_ARM.lengths[2:]
    force = w.node_c + w.link4 + w.node_d + w.payload
    moment = (w.node_d + w.payload) * next_length + w.link4 * next_length / 2
    assert abs(bent[1]) == pytest.approx(
        method.cantilever_slope(length, young * inertia, force, moment, w.link3), rel=1e-9
    )
    shear = (force + w.link3 / 2) * length / (young / 2.6 * area)
    deflection = method.cantilever_deflection(length, young * inertia, force, moment, w.link3)
    assert np.hypot(*bent[4:]) == pytest.approx(deflection + shear, rel=1e-9)
    stiffness = max(method.stiffness_for_limits(length, force, moment, w.link3))
    assert method.cantilever_slope(length, stiffness, force, moment, w.link3) == pytest.approx(
        0.5 * method.ARCMIN
    )
    assert method.cantilever_deflection(length, stiffness, force, moment, w.link3) < length / 2500

    def printed(unit):
        names = {
            "length": length * unit,
            "next_length": next_length * unit,
            "moment": moment * unit,
            "stiffness": stiffness * unit**2,
        }
        return method.slope_as_printed(
            **names, reaction=force + w.link3, node_weight=w.node_c, own_weight=w.link3
        )

    assert printed(1000) / printed(1) > 100


def test_the_arithmetic_of_section_6_3():
    """0.00066 rad is 2.2689'; the printed parts add to 3.26177', and only the unrounded 2.2689'
    gives the 3.27' that is stated.
    """
    assert method.strain_read_as_angle() == pytest.approx(2.2689, abs=5e-5)
    assert method.sum_of_maxima(method.TRANSMISSION_ARCMIN) == pytest.approx(3.26177, abs=1e-9)
    assert method.sum_of_maxima(method.strain_read_as_angle()) == pytest.approx(3.2707, abs=5e-5)
    assert f"{method.sum_of_maxima(method.strain_read_as_angle()):.2f}" == "3.27"
    assert f"{method.sum_of_maxima(method.TRANSMISSION_ARCMIN):.2f}" == "3.26"


def test_extremes_move_with_the_number_of_samples():
    """A longer run begins with the shorter one's samples, so its smallest can only fall and its
    largest only rise; and they do.
    """
    found = method.deviations(Z_ARM, 1_000_000, 1)
    assert np.array_equal(method.deviations(Z_ARM, 1000, 1), found[:1000])
    assert found.min() < found[:1000].min() / 5
    assert found.max() > 1.2 * found[:1000].max()


def test_sixty_micrometres_over_fifty_millimetres_tilt_an_axis_by_more_than_the_whole_angle_budget():
    """The engine's pair of bearings at O, under the arm's weight: 4.125', where the paper allows
    3.27' for everything.
    """
    described = tomllib.loads(ARM_FILE.read_text("utf-8"))
    for joint in described["joints"]:
        del joint["lumped"]
    described["joints"][0]["bearing"] = {"kind": "rolling", "clearance": "60 µm", "span": "50 mm"}
    bias = lostmotion.screws(
        lostmotion.state_of(
            lostmotion.Arm.model_validate(described), np.radians([[0.0, 180.0, 135.0, 180.0]])
        )
    ).bias[0]
    tilt = np.linalg.norm(bias[:3]) / method.ARCMIN
    assert tilt == pytest.approx(60e-6 / 50e-3 / method.ARCMIN)
    assert tilt > method.JOINT_ARCMIN
