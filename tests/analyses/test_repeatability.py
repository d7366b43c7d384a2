"""Repeatability by how joints arrive, and the remedies against play: one meaning on every surface,
and no sentence that forgets one.
"""

from __future__ import annotations

import io
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import lostmotion
from lostmotion.analyses.sizing.selection import StudySize, select_parts
from lostmotion.error_model import remedies
from lostmotion.error_model.arrival import rp_name
from lostmotion.error_model.expected_repeatability import visit_covariance
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.poses import Poses, sample_poses
from lostmotion.error_model.robot_intervals import pooled_robots_quantile
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.standing import standing
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.analytic import analytic
from lostmotion.propagation.iso9283.cube import Cube
from lostmotion.propagation.iso9283.robots import predict_robots
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.reporting.first_screen import print_first_screen
from lostmotion.reporting.screen import print_sheet
from lostmotion.sizing.candidates import Objective, PartCandidate, Slot
from lostmotion.sizing.error_cache import BIAS, COVARIANCE, ErrorCache

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "RP of a study in the ISO cycle",
        "`iso9283` at its five poses",
        "1e-7",
        "propagation/montecarlo/repeatability.py",
    ),
    (
        "remedies: output encoders, known side",
        "arms with these encoders; Monte Carlo with fixed sides",
        "1e-9; 1e-12",
        "error_model/remedies.py",
    ),
)

pytestmark = pytest.mark.usefixtures("few_samples")

HERE = Path(__file__).parent
EXAMPLES = HERE.parents[1] / "examples"
MILL = HERE / "worn-mill.toml"


def scattering_arm() -> Arm:
    """Return an arm of three joints with everything that scatters from one side, and backlash and
    hysteresis besides.
    """
    joints = [
        {
            "name": name,
            "type": "revolute",
            "axis": axis,
            "limits": (-2.0, 2.0),
            "gearbox": {
                "ratio": 50.0,
                "backlash": 4e-4,
                "hysteresis": 2e-4,
                "hysteresis_scatter": 0.3,
                "stiffness": 2e4,
                "rated_torque": 20.0,
            },
            "encoder": {"side": "motor", "resolution": 1e-3},
            "servo": {"dead_band": 5e-3},
            "link": {"length": 0.3, "mass": 1.0, "rigid": True},
        }
        for name, axis in (("A", "z"), ("B", "y"), ("C", "y"))
    ]
    return Arm.model_validate({"name": "three joints", "joints": joints})


def test_the_study_has_the_rp_of_the_iso_command_at_its_poses():
    """At the five poses of a cube every robot has the RP of the standard's cycle and of any
    approach that `iso9283` computes from the same draws.
    """
    arm = scattering_arm()
    q = np.array(
        [[0.1, -0.4, 0.9], [0.3, -0.2, 0.7], [0.3, -0.6, 1.2], [-0.2, -0.5, 1.1], [-0.3, -0.3, 0.8]]
    )
    cube = Cube(np.zeros(3), 0.1, None, q, state_of(arm, q).frames[-1], 0, np.nan, "given")
    iso = predict_robots(arm, cube, cycles=30, robots=40, loads=(1.0,)).loads[0]
    study = lostmotion.study(arm, Poses(q, "given"), robots=40, visits=30)
    cycle, either = study.repeats
    np.testing.assert_allclose(cycle.per_pose[:, 0], iso.repeatability.mean(axis=1), rtol=1e-7)
    np.testing.assert_allclose(either.per_pose[:, 0], iso.random_approach.mean(axis=1), rtol=1e-7)
    assert (cycle.per_pose[:, 0] < either.per_pose[:, 0]).all()


def test_it_does_not_matter_which_run_the_study_makes_first():
    """A study of joints that arrive moving up has the same two repeatabilities as one of joints
    that arrive from either side.
    """
    studies = [
        lostmotion.study(scattering_arm(), 8, robots=8, visits=4, approach=way)
        for way in ("random", "up")
    ]
    for one, other in zip(*(study.repeats for study in studies), strict=True):
        assert one.approach == other.approach
        np.testing.assert_allclose(one.per_pose, other.per_pose, rtol=1e-7)
    assert [rp_name(each.approach) for each in studies[0].repeats] == [
        "RP, ISO cycle",
        "RP, any approach",
    ]


def test_shares_of_what_rp_is_made_of_are_those_of_the_variances():
    """From one side: uniform dead band and count, cut normal friction; the same of every joint, so
    that any pose has these shares.
    """
    study = lostmotion.study(scattering_arm(), 8, robots=8, visits=4)
    cut = 0.97334  # of the variance of a normal distribution, cut at three standard deviations
    band, friction, count = (5e-3 / 50) ** 2 / 3, (0.3 * 1e-4 / 3) ** 2 * cut, (1e-3 / 50) ** 2 / 12
    whole = band + friction + count
    expected = {
        "servo dead band": band / whole,
        "gearbox hysteresis scatter": friction / whole,
        "encoder resolution": count / whole,
    }
    assert dict(study.repeats[0].causes) == pytest.approx(expected, rel=1e-4)
    assert sum(share for _, share in study.repeats[1].causes) == pytest.approx(1.0)


@pytest.mark.usefixtures("unpainted")
def test_bars_of_what_rp_is_made_of_are_the_table_s_figures(tmp_path):
    """Both approaches have a block of bars, of the table's own figures and on one scale to 100 %,
    on the page and in the full output alone.
    """
    study = lostmotion.study(scattering_arm(), 8, robots=8, visits=4)
    section = next(each for each in study.sheet.sections if each.key == "rp_made_of")
    repeats = {
        row.label.partition(", 95th")[0]: str(row.cells[0]).lstrip("≥ ")
        for each in study.sheet.sections
        if each.key == "iso9283"
        for row in each.rows
    }
    assert len(section.bars) == len(section.columns) == 2
    for column, (block, name) in enumerate(
        zip(section.bars, ("RP, ISO cycle", "RP, any approach"), strict=True)
    ):
        assert [(bar.label, bar.figure) for bar in block.bars] == [
            (row.label, row.cells[column]) for row in section.rows
        ]
        assert sum(bar.size for bar in block.bars) == pytest.approx(1)
        assert block.ends == (0, 1)
        # No bearing is described, so that RP is a lower bound.
        assert block.title == f"{name}: at least {repeats[name]}"
        assert block.note == "shares of what is described"
    page = study.report(tmp_path / "out").joinpath("report.html").read_text("utf-8")
    described = re.findall(r'<div class="bars" role="img" aria-label="([^"]+)"', page)
    assert len(described) == 2
    full, brief = (Console(file=io.StringIO(), width=80) for _ in range(2))
    print_sheet(study.sheet, full)
    print_first_screen(study.sheet, brief)
    for block, words in zip(section.bars, described, strict=True):
        assert words.startswith(f"Bars. {block.title}; share of the mean square: ")
        assert all(f"{bar.label} {bar.figure}" in words for bar in block.bars)
        assert block.title in full.file.getvalue()
        assert f"{block.title}  " not in brief.file.getvalue()


def test_an_approach_without_scatter_has_no_bars():
    """Where backlash alone errs, it repeats in the standard's cycle: no RP is predicted there,
    neither by a bar nor by a share of zero.
    """
    joint = {
        "name": "A",
        "type": "revolute",
        "axis": "z",
        "limits": (-1, 1),
        "gearbox": {"backlash": 4e-4},
        "link": {"length": 0.3, "rigid": True},
    }
    sheet = lostmotion.study(
        Arm.model_validate({"name": "play", "joints": [joint]}), 16, robots=8, visits=4
    ).sheet
    section = next(each for each in sheet.sections if each.key == "rp_made_of")
    assert [str(figure) for figure in section.rows[0].cells] == ["not predicted", "100 %"]
    assert [block.title.partition(":")[0] for block in section.bars] == ["RP, any approach"]


def test_a_mill_with_worn_screws_is_cured_by_a_known_side():
    """Play of 0.2 mm: no compensation or calibration helps, a known side leaves less than a tenth,
    and the answer says so.
    """
    study = lostmotion.study(MILL, 256, robots=200, visits=10)
    left = {stage.name: stage.q95.value for stage in study.waterfall.stages}
    assert left["as manufactured"] == pytest.approx(0.1e-3, rel=0.05)
    assert left["both, and each robot mapped"] == left["as manufactured"]
    assert left[remedies.ONE_SIDE] == pytest.approx(left["as manufactured"], rel=0.05)
    # y scatters by half of its ±25 µm: 95 % of |normal cut at three standard deviations|
    assert left[remedies.SIDE_KNOWN] == pytest.approx(12.5e-6 / 3 * 1.95, rel=0.06)
    assert left[remedies.OUTPUT_ENCODERS] == 0
    assert "a controller that knows the side of arrival leaves" in study.sheet.verdict
    assert "no remedy" not in study.sheet.verdict.lower()


@pytest.mark.parametrize("approach", [0.0, 1.0])
def test_remedies_without_sampling_leave_the_mean_square_of_bias_and_covariance(approach):
    """At every stage the r.m.s. error is that of the mean vector and covariance, which are summed
    by cumulants instead of by columns.
    """
    arm = scattering_arm()
    poses = sample_poses(arm, 64, "sobol", 1)
    found = remedies.remaining_rms(arm, poses, approach=approach)
    assert list(found) == list(remedies.EVERY_STAGE)
    for stage, rms in found.items():
        square = analytic(arm, poses, stage=stage, approach=approach).mean_square.mean()
        assert rms.value == pytest.approx(np.sqrt(square), rel=1e-9, abs=1e-15), stage
        assert rms.low <= rms.value <= rms.high


def test_a_study_without_sampling_shows_the_remedies_against_play():
    """The bars of worn screws without sampling name the known side and output encoders, and the
    table has every remedy.
    """
    sheet = lostmotion.study(MILL, 64, method="analytic").sheet
    bars = {
        bar.label: bar.figure
        for block in sheet.bars
        if block.key == "remedies"
        for bar in block.bars
    }
    assert list(bars)[-2:] == ["side of arrival known", "output encoders"]
    # y scatters by half of its ±25 µm: a normal distribution, cut at three standard deviations
    assert bars["side of arrival known"].value == pytest.approx(12.5e-6 / 3 * 0.98658, rel=1e-4)
    rows = [
        row.label for section in sheet.sections if section.key == "remedies" for row in section.rows
    ]
    assert rows == list(remedies.EVERY_STAGE)


def test_a_known_side_leaves_what_fixed_sides_leave_but_for_their_mean():
    """Arriving from one side is a run with fixed sides; a known side takes off what changes its
    sign with the side, and nothing else.
    """
    arm, poses = scattering_arm(), Poses(np.random.default_rng(1).uniform(-1, 1, (16, 3)), "given")
    up, down = (run(arm, poses, 50, 4, 1, approach=side).bias[:, 3:] for side in (1.0, -1.0))
    one_side, known = (
        analytic(arm, poses, stage=stage) for stage in (remedies.ONE_SIDE, remedies.SIDE_KNOWN)
    )
    np.testing.assert_allclose(one_side.bias, up, rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(one_side.covariance, known.covariance, rtol=1e-12)
    # what the side adds changes its sign with the side, so that the middle of both is free of it
    np.testing.assert_allclose(known.bias, (up + down) / 2, rtol=1e-12, atol=1e-16)
    assert np.abs(up - down).max() > 1e-5


def test_output_encoders_leave_what_an_arm_with_them_has():
    """The same arm with encoders on its outputs, where they and the dead bands of the servos are as
    large as now: mean and covariance are equal in the frames where the arm stands.
    """
    arm, poses = scattering_arm(), Poses(np.random.default_rng(2).uniform(-1, 1, (16, 3)), "given")

    def measured(joint):
        encoder = joint.encoder.model_copy(
            update={
                "side": "output",
                "resolution": joint.encoder.resolution / 50,
                "dead_band": None,
            }
        )
        return joint.model_copy(
            update={
                "encoder": encoder,
                "servo": joint.servo.model_copy(update={"dead_band": 5e-3 / 50}),
            }
        )

    found = analytic(arm, poses, stage=remedies.OUTPUT_ENCODERS)
    stands = standing(state_of(arm, poses.q))
    matrix = screws(
        state_of(
            arm.model_copy(update={"joints": tuple(map(measured, arm.joints))}),
            poses.q,
            frames=stands.frames,
        )
    )
    shift = matrix.merged.tool[:, 3:, matrix.merged.columns("robot", "visit", "robot x visit")]
    np.testing.assert_allclose(found.bias, matrix.bias[:, 3:], atol=1e-15)
    np.testing.assert_allclose(
        found.covariance, shift @ shift.transpose(0, 2, 1), rtol=1e-9, atol=1e-24
    )
    assert np.abs(analytic(arm, poses).bias).max() > 1e-5


def test_torque_sensors_take_a_part_of_what_load_compensation_takes():
    """The nominal wind-up of drives goes; hysteresis and what differs from robot to robot or visit
    to visit stays.
    """
    arm, poses = scattering_arm(), Poses(np.random.default_rng(3).uniform(-1, 1, (16, 3)), "given")
    plain, sensed, compensated = (
        analytic(arm, poses, stage=stage)
        for stage in ("as manufactured", remedies.TORQUE_SENSORS, "load compensated")
    )
    np.testing.assert_allclose(sensed.covariance, plain.covariance, rtol=1e-12)
    # links are rigid here, so that the drives are all that a load deflects
    np.testing.assert_allclose(sensed.bias, compensated.bias, atol=1e-15)


NAMED = re.compile(r"\bRP(?:_l)?\b(?!, (?:ISO cycle|any approach))")


def _asked():
    arm = scattering_arm()
    few = {"robots": 20, "visits": 3}
    yield "study", lostmotion.study(arm, 8, **few)
    yield "study from above", lostmotion.study(arm, 8, **few, approach="up")
    yield "study in a zone", lostmotion.study(arm, 8, **few, zone="z -1..1 m")
    yield "study until", lostmotion.study(arm, 8, **few, until="50 %", most_robots=40)
    yield (
        "compare",
        lostmotion.compare(arm, arm.model_copy(update={"name": "other"}), poses=8, **few),
    )
    for key in ("rp_iso", "rp_any"):
        yield f"target {key}", lostmotion.target(arm, **{key: "0.5 mm"}, poses=8, **few)


@pytest.mark.parametrize(
    "name",
    [
        "study",
        "study from above",
        "study in a zone",
        "study until",
        "compare",
    ],
)
def test_rp_is_never_shown_without_the_approach(results, name):
    """Card titles, row labels, columns, answers and statements name the approach wherever they name
    RP.
    """
    sheet = results[name].sheet
    texts = (
        [card.title for card in sheet.cards]
        + [sheet.verdict]
        + [text for word, text in sheet.brief if word != "RP"]
    )
    texts += [
        f"RP, {text.split('RP, ', 1)[1]}"
        for word, text in sheet.brief
        if word == "RP" and "RP, " in text
    ]
    for section in sheet.sections:
        texts += (
            [*section.columns, *(row.label for row in section.rows)]
            if section.key != "inputs"
            else []
        )
    assert [text for text in texts if NAMED.search(text)] == []
    assert any("ISO cycle" in text or "any approach" in text for text in texts)


def test_both_repeatabilities_are_on_the_first_screen(results):
    """As cards and in the statement on RP, with the largest causes of each."""
    sheet = results["study"].sheet
    titles = [card.title for card in sheet.cards]
    assert {
        "RP, ISO cycle, 95 % of robots within",
        "RP, any approach, 95 % of robots within",
    } <= set(titles)
    (text,) = [text for word, text in sheet.brief if word == "RP"]
    assert re.search(
        r"RP, ISO cycle (?:at least )?\S+ \S+ \(servo dead band .*RP, any approach (?:at least )?\S+ \S+ \(gearbox",
        text,
    )


@pytest.mark.parametrize(("key", "other"), [("rp_iso", "rp_any"), ("rp_any", "rp_iso")])
def test_a_target_on_rp_is_one_of_two(results, key, other):
    """Each has its own figure as stated, by the same definition as the study's, and names it."""
    own = results[f"target {key}"]
    named = {"rp_iso": "RP, ISO cycle", "rp_any": "RP, any approach"}
    assert named[key] in own.sheet.verdict + str(own.sheet.sections)
    assert named[other] not in own.sheet.verdict
    assert own.approach == (key == "rp_iso")


@pytest.fixture(scope="module")
def results():
    """Return the result of every command that shows RP, by name."""
    return dict(_asked())


def test_the_old_target_on_repeatability_asks_which_one_is_meant(results):
    """Without a side it is ambiguous; with one it is that of the ISO cycle, as before."""
    with pytest.raises(lostmotion.InputError, match="rp_iso"):
        lostmotion.target(scattering_arm(), repeatability="0.5 mm", poses=8, robots=20, visits=3)
    old = lostmotion.target(
        scattering_arm(), repeatability="0.5 mm", approach="up", poses=8, robots=20, visits=3
    )
    new = results["target rp_iso"]
    assert (old.current.value, old.current.low, old.approach) == (
        new.current.value,
        new.current.low,
        new.approach,
    )


def test_a_target_on_rp_is_not_met_by_what_is_not_described():
    """Where no described error differs between visits a repeatability is unknown, and a target on
    it is refused; backlash that no load closes scatters if the side is drawn, and only then.
    """
    words = {"poses": 8, "robots": 20, "visits": 3}
    with pytest.raises(lostmotion.InputError, match="no described error differs between visits"):
        lostmotion.target(EXAMPLES / "planar-2r.toml", rp_any="1 mm", **words)
    text = (EXAMPLES / "planar-2r.toml").read_text("utf-8")
    upright = text.replace('"-y"', '"z"').replace('"0 arcmin", h', '"1 arcmin", h')
    loose = lostmotion.read(tomllib.loads(upright))
    assert lostmotion.target(loose, rp_any="1 mm", **words).current.value > 0
    with pytest.raises(lostmotion.InputError, match="no described error differs between visits"):
        lostmotion.target(loose, rp_iso="1 mm", **words)


@pytest.mark.parametrize(("of", "approach"), [("rp_iso", 1.0), ("rp_any", 0.0)])
def test_a_sizing_for_rp_sums_what_differs_between_visits(of, approach):
    """Its covariance at every pose is that of a robot's visits, and no mean counts."""
    arm, q = scattering_arm(), np.random.default_rng(4).uniform(-1, 1, (8, 3))
    sums = ErrorCache(arm, q, of).of(arm)
    covariance = visit_covariance(screws(state_of(arm, q), approach=approach))
    assert not sums[BIAS].any()
    np.testing.assert_allclose(
        sums[COVARIANCE],
        [covariance[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))],
        atol=1e-20,
    )


def test_parts_are_selected_for_rp_in_the_iso_cycle():
    """A heavier drive with less scatter of friction is taken only where the target needs it, and
    the figure is the study's own.
    """
    arm = scattering_arm()

    def offered(joint):
        quiet = joint.gearbox.model_copy(update={"hysteresis_scatter": 0.03})
        stated = PartCandidate("as stated", None, 1.0)
        return Slot(
            joint.name,
            "gearbox",
            (stated, PartCandidate("quiet", quiet, 2.0)),
            stated,
            mass_in_joint=1.0,
        )

    slots = tuple(map(offered, arm.joints))
    poses = sample_poses(arm, 64)
    size = StudySize(50, 10)
    found = {
        target: select_parts(
            arm,
            slots,
            Objective(),
            target,
            sample_poses(arm, 16),
            poses,
            study_size=size,
            of="rp_iso",
        )
        for target in (1.0, 1e-9)
    }
    loose, strict = found[1.0], found[1e-9]
    assert [part.selected.name for part in loose.parts] == ["as stated"] * 3
    assert [part.selected.name for part in strict.parts] == ["quiet"] * 3
    assert not strict.meets_target
    assert loose.quantity == "RP, ISO cycle, of 95 % of robots"
    means = lostmotion.study(loose.sized, poses, robots=50, visits=10).repeats[0].robot_means
    assert loose.error.value == pytest.approx(pooled_robots_quantile(means).value, rel=1e-12)
