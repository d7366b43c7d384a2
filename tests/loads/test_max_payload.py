"""The largest payload of an arm and the stiffness of its tool along x, y and z, against closed
forms.
"""

import math
import re

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.poses import Poses, sample_poses
from lostmotion.loads.payload import max_payload
from lostmotion.mechanism.holding_torques import worst_torques_over_tilts
from lostmotion.mechanism.state import state_of
from lostmotion.mechanism.tool import Payload
from lostmotion.reporting.layout import row_at
from tests.parts.random_arms import EXAMPLES

VALIDATES = (
    (
        "largest payload by drives, sag and accuracy",
        (
            "closed forms of a planar arm's torques and springs; the worst torque within a tilt; "
            "Monte Carlo at the worst pose"
        ),
        "1e-7; 1e-6; 1e-6; 2 %",
        "loads/payload.py",
    ),
    (
        "stiffness of the tool along x, y, z",
        "two slides of a mill as springs in series; bending, shear and stretching of a cantilever",
        "1e-6; 0.3 %",
        "mechanism/elastostatics.py",
    ),
)
G = 9.80665
UPPER, FORE = 0.4, 0.3
ARCMIN = math.pi / 10800
PLANAR = """
name = "planar 2R"
[payload]
mass = "2 kg"
[[joints]]
name = "shoulder"
type = "revolute"
axis = "-y"
limits = ["-90 deg", "90 deg"]
gearbox = { stiffness = "20 N m/arcmin", rated_torque = "100 N m", backlash = "1 arcmin" }
link = { length = "400 mm", rigid = true, mass = "3 kg" }
[[joints]]
name = "elbow"
type = "revolute"
axis = "-y"
limits = ["-90 deg", "90 deg"]
gearbox = { stiffness = "5 N m/arcmin", rated_torque = "30 N m", backlash = "1 arcmin" }
link = { length = "300 mm", rigid = true, mass = "2 kg" }
"""
# A massless lever of 0.3 m; the drive of its joint is added.
LEVER = """
name = "servo"
[payload]
mass = "0.5 kg"
[[joints]]
name = "lift"
type = "revolute"
axis = "-y"
limits = ["-90 deg", "90 deg"]
link = { length = "300 mm", rigid = true }
"""
POSES = np.radians([[0.0, 0.0], [30.0, 40.0], [-20.0, 50.0], [60.0, -70.0]])
# A milling machine as two slides in series: the work on the bed, the tool on the spindle's slide.
MILL = """
name = "CNC, bed and spindle side in series"
[[joints]]
name = "bed"
type = "prismatic"
axis = "y"
limits = ["-100 mm", "100 mm"]
bearing = { kind = "rolling", clearance = "0 µm", span = "150 mm", radial_stiffness = "0.65 N/µm" }
gearbox = { lead = "8 mm", stiffness = "0.39 N/µm" }
[[joints]]
name = "spindle"
type = "prismatic"
axis = "x"
limits = ["-100 mm", "100 mm"]
bearing = { kind = "rolling", clearance = "0 µm", span = "150 mm", radial_stiffness = "3.9 N/µm" }
gearbox = { lead = "8 mm", stiffness = "0.65 N/µm" }
"""
CANTILEVER = """
name = "cantilever"
[payload]
mass = "1 g"
[[joints]]
name = "A"
type = "revolute"
axis = "y"
limits = ["-90 deg", "90 deg"]
link = { length = "500 mm", mass = "0 kg", section = { kind = "tube", outer = "40 mm", wall = "2 mm" }, material = "aluminium" }
"""


def arm_of(folder, text):
    """Return the arm of a file with this text."""
    path = folder / "arm.toml"
    path.write_text(text, encoding="utf-8")
    return lostmotion.read(path)


def horizontal(q):
    """Return how far the tip lies in front of each joint of the planar arm (pose, joint), m."""
    fore = FORE * np.cos(q.sum(axis=1))
    return np.column_stack([UPPER * np.cos(q[:, 0]) + fore, fore])


def own_torques(q):
    """Return what the weights of the planar arm's links ask of its drives (pose, joint), N m: each
    acts at the middle of its link.
    """
    fore = 2 * G * FORE / 2 * np.cos(q.sum(axis=1))
    upper = 3 * G * UPPER / 2 * np.cos(q[:, 0]) + 2 * G * UPPER * np.cos(q[:, 0])
    return np.column_stack([upper + fore, fore])


def test_the_drives_of_a_planar_arm_hold_what_their_rated_torques_allow(tmp_path):
    """The largest payload is (rated torque - own moment) / (g x horizontal distance), the smaller
    of both joints, at every pose.
    """
    found = max_payload(arm_of(tmp_path, PLANAR), Poses(POSES, "given"), None, None, None)
    each = (np.array([100.0, 30.0]) - own_torques(POSES)) / (G * horizontal(POSES))
    np.testing.assert_allclose(found.limits[0].values, each.min(axis=1), rtol=1e-7)
    np.testing.assert_array_equal(found.limits[0].joints, each.argmin(axis=1))
    assert found.governing.everywhere == pytest.approx(each.min())
    assert found.unrated == ()


def test_the_largest_payload_just_holds_on_a_tilted_base(tmp_path):
    """With the largest payload within a tilt, one drive holds exactly its rated torque in the worst
    direction, and none holds more.
    """
    arm, tilt = arm_of(tmp_path, PLANAR), math.radians(25)
    values = max_payload(arm, Poses(POSES, "given"), tilt, None, None).limits[0].values
    for q, mass in zip(POSES, values, strict=True):
        loaded = arm.with_payload(arm.payload.model_copy(update={"mass": float(mass)}))
        shares = worst_torques_over_tilts(state_of(loaded, q[None]), within=tilt)[0] / [100.0, 30.0]
        assert shares.max() == pytest.approx(1.0, abs=1e-6)
    level = max_payload(arm, Poses(POSES, "given"), None, None, None).limits[0].values
    assert (values <= level * (1 + 1e-9)).all()


def test_the_sag_of_a_planar_arm_follows_its_springs(tmp_path):
    """Each joint turns by its torque over its stiffness and moves the tip by that times its
    distance: with the largest payload by the limit.
    """
    arm, limit = arm_of(tmp_path, PLANAR), 2e-3
    values = max_payload(arm, Poses(POSES, "given"), None, limit, None).limits[1].values
    stiffness = np.array([20.0, 5.0]) / ARCMIN
    for q, mass in zip(POSES, values, strict=True):
        x, own = horizontal(q[None])[0], own_torques(q[None])[0]
        elbow = UPPER * np.array([math.cos(q[0]), math.sin(q[0])])
        tip = elbow + FORE * np.array([math.cos(q.sum()), math.sin(q.sum())])
        turned = (own + mass * G * x) / stiffness
        shift = sum(
            angle * np.array([arm_z, -arm_x])
            for angle, (arm_x, arm_z) in zip(turned, (tip, tip - elbow), strict=True)
        )
        assert np.linalg.norm(shift) == pytest.approx(limit, rel=1e-6)


def test_the_sag_of_a_soft_arm_is_that_where_it_stands(tmp_path):
    """A massless link of 0.3 m on 5 N m/rad turns by t where K t = m g l cos(c - t), and its tip
    moves by 2 l sin(t/2): the payload in closed form, at a droop of 19 degrees.
    """
    text = LEVER + 'gearbox = { ratio = 100, stiffness = "5 N m/rad" }'
    arm, limit, command = arm_of(tmp_path, text), 0.1, np.radians([[0.0], [40.0]])
    assert arm.soft_freedoms
    turn = 2 * math.asin(limit / 2 / 0.3)
    expected = 5 * turn / (G * 0.3 * np.cos(command[:, 0] - turn))
    for c, mass in zip(command, expected, strict=True):
        found = max_payload(arm, Poses(c[None], "given"), None, limit, None).limits[1]
        assert found.values[0] == pytest.approx(mass, rel=1e-4)
    both = max_payload(arm, Poses(command, "given"), None, limit, None).limits[1]
    assert both.values == pytest.approx(expected, rel=0.01)
    assert both.everywhere == pytest.approx(expected.min(), rel=1e-4)


def test_the_sag_of_a_soft_arm_is_its_springs_alone(tmp_path):
    """A play of 2 degrees moves the tool of a lever by 5 mm, and 40 K lengthen it by 0.3 mm: neither
    is a sag, of a soft arm as of a stiff one.
    """
    drive = 'gearbox = {{ ratio = 100, stiffness = "5 N m/rad"{} }}\n'
    tube = 'mass = "0 kg", section = { kind = "tube", outer = "40 mm", wall = "2 mm" }'
    lever = LEVER.replace("rigid = true", f'{tube}, material = "aluminium"')
    warm = '[environment]\ntemperature = "60 °C"\nreference_temperature = "20 °C"\n'
    plain, other = lever + drive.format(""), lever + drive.format(', backlash = "2 deg"') + warm
    arms = [arm_of(tmp_path, text) for text in (plain, other)]
    assert all(arm.soft_freedoms for arm in arms)
    moved = [np.linalg.norm(screws(state_of(arm, [[0.3]])).bias[0, 3:]) for arm in arms]
    assert abs(moved[1] - moved[0]) > 1e-4
    command = np.radians([[0.0], [40.0]])
    one, two = (
        max_payload(arm, Poses(command, "given"), None, 0.02, None).limits[1].values for arm in arms
    )
    assert one.min() > 0
    assert two == pytest.approx(one, rel=1e-6)


def test_a_soft_closed_chain_sags_to_first_order(tmp_path):
    """A palletiser on drives that are 3 438 times softer has its largest payload by sag at a sag of
    the limit, at the worst pose.
    """
    text = (EXAMPLES / "closed-chains" / "parallelogram-palletiser.toml").read_text("utf-8")
    text, changed = re.subn(r'(stiffness = "[0-9.]+) N m/arcmin"', r'\1 N m/rad"', text)
    arm = arm_of(tmp_path, text)
    assert changed
    assert arm.soft_freedoms
    poses = sample_poses(arm, 64)
    found = max_payload(arm, poses, None, 1.0, None).limits[1]
    assert 0 < found.everywhere < 1000
    payload = Payload(mass=found.everywhere, centre_of_mass=arm.payload.centre_of_mass)
    sag = np.linalg.norm(state_of(arm.with_payload(payload), poses.q).sag[:, 3:], axis=1)
    assert sag.max() == pytest.approx(1.0, rel=1e-3)


def test_the_accuracy_limit_is_met_with_the_largest_payload_and_not_above(tmp_path):
    """A study of the worst pose by Monte Carlo with that payload has 95 % of its positions within
    the limit, to 2 %; with a tenth more it has not.
    """
    arm, limit = arm_of(tmp_path, PLANAR), 0.5e-3
    found = max_payload(arm, lostmotion.sample_poses(arm, 64), None, None, limit).limits[1]
    q = found.q[[found.worst]]

    def within(mass):
        loaded = arm.with_payload(arm.payload.model_copy(update={"mass": mass}))
        study = lostmotion.study(loaded, Poses(q, "given"), robots=2000, visits=10)
        return row_at(study.sheet.sections, "error", "p95").cells[0].as_shown * 1e-3

    assert within(found.everywhere) == pytest.approx(limit, rel=0.02)
    assert within(1.1 * found.everywhere) > limit


def test_an_arm_that_cannot_hold_itself_holds_no_payload(tmp_path):
    """A drive overloaded by the arm alone leaves nothing for a payload, and the headline says so
    with the number of poses.
    """
    weak = arm_of(tmp_path, PLANAR.replace('"30 N m"', '"1 N m"'))
    sheet = lostmotion.statics(weak, poses=64, max_payload=True).sheet
    over = int(
        (
            np.abs(
                state_of(
                    weak.with_payload(weak.payload.model_copy(update={"mass": 0.0})),
                    lostmotion.sample_poses(weak, 64).q,
                ).torques
            )
            > [100, 1]
        )
        .any(axis=1)
        .sum()
    )
    assert (
        "No payload is held at every pose: without any, the drive of elbow is overloaded at "
        f"{over} of 64 poses."
    ) in sheet.verdict


def test_drives_without_a_rating_set_no_payload_and_are_named(tmp_path):
    """Without any rating there is no payload by the drives, rather than an infinite one; with one
    of two it is an upper bound.
    """
    none = PLANAR.replace('rated_torque = "100 N m", ', "").replace('rated_torque = "30 N m", ', "")
    sheet = lostmotion.statics(arm_of(tmp_path, none), poses=64, max_payload=True).sheet
    assert "No drive that the payload loads has a rated torque" in sheet.verdict
    assert (
        next(card for card in sheet.cards if card.title == "largest payload, every pose").number
        == "not known"
    )
    assert [
        figure.words for figure in row_at(sheet.sections, "payload", "drives_rated_torque").cells
    ] == ["not rated"] * 3
    one = lostmotion.statics(
        arm_of(tmp_path, PLANAR.replace('rated_torque = "100 N m", ', "")),
        poses=64,
        max_payload=True,
    )
    assert "is at most " in one.sheet.verdict
    assert "No rated torque is stated for shoulder: its load is not counted" in one.sheet.verdict
    assert row_at(one.sheet.sections, "payload", "drives_rated_torque").cells[0].bound == "upper"
    assert one.result()["max_payload"]["not_rated"] == ["shoulder"]


def test_sag_and_accuracy_without_a_described_stiffness_set_no_limit_for_want_of_data(tmp_path):
    """They are not known, so the payload that the drives hold is an upper bound; without such
    limits it is none, and no error is printed that could be one.
    """
    soft = PLANAR.replace('stiffness = "20 N m/arcmin", ', "").replace(
        'stiffness = "5 N m/arcmin", ', ""
    )
    arm = arm_of(tmp_path, soft)
    found = lostmotion.statics(arm, poses=64, sag_limit="1 mm", accuracy_limit="2 mm").sheet
    rows = next(section for section in found.sections if section.key == "payload").rows
    assert [figure.words for figure in rows[1].cells + rows[2].cells] == ["not known"] * 6
    assert "No error that grows with the payload is described, so sag and accuracy set no" in (
        found.verdict
    )
    assert "is at most " in found.verdict
    alone = lostmotion.statics(arm, poses=64, max_payload=True).sheet
    assert "at most" not in alone.verdict
    assert "errors are at least" not in alone.verdict


def test_each_criterion_is_answered_with_what_governs_and_where(tmp_path):
    """A limit of sag or accuracy asks for the payload as well; the smallest of the three is the
    headline's, with its pose in result.json.
    """
    found = lostmotion.statics(
        arm_of(tmp_path, PLANAR), poses=64, sag_limit="1 mm", accuracy_limit="0.5 mm"
    )
    criteria = found.result()["max_payload"]["criteria"]
    assert list(criteria) == ["drives", "sag", "accuracy"]
    governing = min(criteria, key=lambda name: criteria[name]["every_pose_kg"])
    assert found.result()["max_payload"]["governing"] == governing
    assert criteria["sag"]["limit_m"] == 1e-3
    section = next(section for section in found.sheet.sections if section.key == "payload")
    assert [row.label for row in section.rows] == [
        "drives, rated torque",
        "sag within 1 mm",
        "accuracy within 0.5 mm",
    ]
    assert all("pose " in row.note and "tool at x " in row.note for row in section.rows)
    assert {plot.section for plot in found.plots} >= {"payload", "map"}


def test_the_slides_of_a_mill_are_springs_in_series(tmp_path):
    """Along x the spindle's screw and the bed's two carriages yield; along y the bed's screw, the
    spindle's carriages, and the bed's yaw times x.
    """
    arm = arm_of(tmp_path, MILL)
    found = lostmotion.statics(arm, poses=np.array([[0.0, 0.0], [0.03, 0.1]]))
    along_x = 1 / (1 / 0.65 + 1 / (2 * 0.65))
    yaw = 2 * 0.65e6 * 0.075**2  # N m/rad of two carriages 150 mm apart
    along_y = [1 / (1 / 0.39 + 1 / (2 * 3.9) + 1e6 * x**2 / yaw) for x in (0.0, 0.1)]
    worst_x, _, best_x = (
        figure.as_shown for figure in row_at(found.sheet.sections, "axes", "along_x").cells
    )
    worst_y, _, best_y = (
        figure.as_shown for figure in row_at(found.sheet.sections, "axes", "along_y").cells
    )
    assert worst_x == best_x == pytest.approx(along_x, rel=1e-6)
    assert (worst_y, best_y) == pytest.approx((along_y[1], along_y[0]), rel=1e-6)
    compliance = lostmotion.state_of(arm, found.poses.q).compliance
    np.testing.assert_allclose(
        found.axis_compliance, np.einsum("pii->pi", compliance[:, 3:, 3:]), rtol=1e-12
    )
    parts = {
        row.label: [figure.as_shown for figure in row.cells]
        for row in next(s for s in found.sheet.sections if s.key == "axes-parts").rows
    }
    assert parts["spindle.gearbox"] == [pytest.approx(0.65), math.inf, math.inf]
    assert parts["bed.gearbox"] == [math.inf, pytest.approx(0.39), math.inf]
    assert parts["bed.bearing"][0] == pytest.approx(2 * 0.65)
    assert (
        f"Along x, y, z the tool's stiffness is {along_x:.3f} N/µm, {along_y[1]:.3f} N/µm"
        in found.sheet.verdict
    )


def test_a_cantilever_is_as_stiff_as_its_bending_and_stretching(tmp_path):
    """3 E I / L^3 with the shear of a thin tube across the beam, E A / L along it; at 45 degrees
    the mean of both compliances. The load is so small that the beam is straight: sagged by an angle
    a, it is softer along itself by a^2 times its compliance across.
    """
    found = lostmotion.statics(
        arm_of(tmp_path, CANTILEVER), poses=np.radians([[0.0], [45.0], [90.0]])
    )
    young, poisson = (
        getattr(found.arm.joints[0].link.material, name) for name in ("young", "poisson")
    )
    outer, inner, span = 0.04, 0.036, 0.5
    area, second = math.pi / 4 * (outer**2 - inner**2), math.pi / 64 * (outer**4 - inner**4)
    bending, stretching = span**3 / (3 * young * second), span / (young * area)
    # a thin tube's shear factor is about one half
    shear = 2 * span / (young / (2 * (1 + poisson)) * area)
    across, along = found.axis_compliance[0, 2], found.axis_compliance[0, 0]
    assert across == pytest.approx(bending + shear, rel=3e-3)
    assert along == pytest.approx(stretching, rel=1e-6)
    assert found.axis_compliance[2, 0] == pytest.approx(across, rel=1e-6)
    assert found.axis_compliance[1, 2] == pytest.approx((across + along) / 2, rel=1e-6)


def test_what_a_servo_feeds_forward_is_no_sag(tmp_path):
    """A stiff arm whose controller knows 70 % of its weights sags by the rest: t = 0.3 m g l / K at
    the horizontal, so that the payload may be more than three times as large.
    """
    servo = 'servo = { stiffness = "2000 N m/rad", gravity_compensation = "SHARE" }'
    text = f"{LEVER}gearbox = {{ ratio = 100 }}\n{servo}"
    limit = 1e-3
    for share in (0.0, 0.7, 0.9):
        arm = arm_of(tmp_path, text.replace("SHARE", f"{share:.0%}"))
        assert not arm.soft_freedoms
        found = max_payload(arm, Poses(np.zeros((1, 1)), "given"), None, limit, None).limits[1]
        expected = limit * 2000 / ((1 - share) * G * 0.3**2)
        assert found.values[0] == pytest.approx(expected, rel=1e-4)
