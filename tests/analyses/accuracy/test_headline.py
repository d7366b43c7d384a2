"""The headline of a study against its figures, on arms of different kinds."""

import re
from pathlib import Path

import lostmotion
from lostmotion.error_model.remedies import SIDE_KNOWN
from lostmotion.reporting.layout import row_at
from lostmotion.reporting.sheet import Cell, length
from tests.reporting.first_screen import first_screen

EXAMPLES = Path(__file__).parents[3] / "examples"
# What a real joint has besides is declared ideal, so that no figure is a lower bound.
REST = 'bearing = { rigid = true }\nencoder = { resolution = "0 deg" }'
PLAY = (
    f'gearbox = {{ backlash = "30 arcmin", friction_torque = "0.1 N m ± 20 %", rigid = true, '
    f'hysteresis = "0 arcmin" }}\n{REST}'
)
IDEAL = (
    f'gearbox = {{ ratio = 100, backlash = "0 arcmin", rigid = true, hysteresis = "0 arcmin" }}\n'
    f"{REST}"
)
WAVE = IDEAL.replace("ratio = 100", 'ratio = 100, transmission_error = "3 arcmin"')


def arm_of(folder, first, second=IDEAL, tolerance="1 µm"):
    """Return an arm of two joints in a level plane with these parts, and links of this
    tolerance.
    """
    link = (
        f'link = {{ length = "300 mm", length_tolerance = "{tolerance}", rigid = true, mass = "1 '
        f'kg" }}'
    )
    joints = [
        (
            f'[[joints]]\nname = "{name}"\ntype = "revolute"\nlimits = ["-140 deg", "140 deg"]\n'
            f"{part}\n{link}\n"
        )
        for name, part in zip("AB", (first, second), strict=True)
    ]
    path = folder / "arm.toml"
    path.write_text('name = "two"\n' + "".join(joints), encoding="utf-8")
    return path


def z_arm(folder, old, new):
    """Return the Z-arm with a text of its file replaced."""
    path = folder / "z.toml"
    text = (EXAMPLES / "z-arm.toml").read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    return path


def small(path, poses=64, robots=60, visits=4):
    """Study an arm at few poses."""
    return lostmotion.study(path, poses, robots=robots, visits=visits)


def check_figures(study):
    """Check every number of the headline against the study's own: 95 % error, level, largest
    contributor, and what is left by a remedy.
    """
    sheet = study.sheet
    assert str(row_at(sheet.sections, "error", "p95").cells[0]) in sheet.verdict
    levels = study.budget.levels
    share, origin = re.search(
        r"(>?[\d.]+ %) of the mean square (follows|differs from robot|differs from visit)",
        sheet.verdict,
    ).groups()
    assert share == str(Cell(max(levels), "%"))
    assert (
        origin == ("follows", "differs from robot", "differs from visit")[levels.index(max(levels))]
    )
    largest = max(study.budget.parts, key=lambda cost: cost.share)
    assert (
        f"(largest contributor: {largest.part.removeprefix('joints.')}, {Cell(largest.share, '%')})"
    ) in sheet.verdict
    return sheet.verdict, {stage.name: stage.q95.value for stage in study.waterfall.stages}


def test_an_arm_led_by_gravity_is_compensated():
    """On the Z-arm the controller takes most off, and the sentence names what it leaves and what is
    assumed.
    """
    verdict, left = check_figures(small(EXAMPLES / "z-arm.toml"))
    assert left["load compensated"] < 0.5 * left["as manufactured"]
    assert f"a controller that knows them leaves {length(left['load compensated'])}" in verdict
    assert (
        f"with a map of each robot as well {length(left['both, and each robot mapped'])}" in verdict
    )
    assert verdict.endswith(
        "This rests on 17 assumed values; not described, so taken as perfect: axis mounting, "
        "base tilt."
    )
    assert len(re.findall(r"[.](?: |$)", verdict)) == 3


def test_play_that_nothing_holds_needs_a_known_side(tmp_path):
    """In a level plane play is crossed from visit to visit: no calibration or compensation helps,
    and a known side does.
    """
    verdict, left = check_figures(small(arm_of(tmp_path, PLAY, PLAY)))
    assert left["both, and each robot mapped"] > 0.97 * left["as manufactured"]
    assert "of the mean square differs from visit to visit" in verdict
    assert left[SIDE_KNOWN] < 0.01 * left["as manufactured"]
    assert (
        f"a controller that knows the side of arrival leaves {length(left[SIDE_KNOWN])}" in verdict
    )


def test_noise_of_an_encoder_has_no_remedy(tmp_path):
    """It differs from visit to visit whatever the side: the sentence names every remedy that was
    tried.
    """
    study = small(arm_of(tmp_path, 'encoder = { noise = "3 arcmin" }'))
    verdict, left = (
        study.sheet.verdict,
        {stage.name: stage.q95.value for stage in study.waterfall.stages},
    )
    assert min(left.values()) > 0.97 * left["as manufactured"]
    assert "no remedy (calibration, compensation, a known side, output encoders)" in verdict
    assert " leaves " not in verdict


def test_wrong_lengths_are_calibrated(tmp_path):
    """Constant errors of each robot vanish by calibration, not by compensation."""
    verdict, _ = check_figures(small(arm_of(tmp_path, IDEAL, tolerance="0.5 mm")))
    assert "calibration of each robot leaves no error to first order" in verdict


def test_a_bent_beam_is_compensated_wholly(tmp_path):
    """A beam of 191 mm that bends by 10 mm is an error of load and pose alone, which is computed
    where the beam stands: nothing is added up, so nothing is neglected; the drive is not described.
    """
    path = tmp_path / "beam.toml"
    path.write_text(
        'name = "beam"\n[payload]\nmass = "1 kg"\n[[joints]]\nname = "A"\ntype = "revolute"\n'
        'axis = "-y"\nlimits = ["-90 deg", "90 deg"]\n'
        'link = { length = "190.8 mm", mass = "0 kg", measured = { force = "9.80665 N", '
        'deflection = "10 mm" } }\n',
        encoding="utf-8",
    )
    sheet = small(path).sheet
    assert "a controller that knows them leaves no described error to first order" in sheet.verdict
    assert "First order: exact to less than 0.001 µm" in dict(sheet.brief)["Trust"]
    analytic = lostmotion.study(path, 64, robots=60, visits=4, method="analytic").sheet
    assert (
        "a controller that knows them leaves no described error to first order" in analytic.verdict
    )


def test_transmission_error_needs_a_map(tmp_path):
    """Harmonics of each robot are neither constant nor a matter of load."""
    verdict, left = check_figures(small(arm_of(tmp_path, WAVE)))
    assert left["both"] > 0.99 * left["as manufactured"]
    assert "only a map of each robot helps" in verdict


def test_lumped_errors_stand_for_every_kind():
    """The paper's arm describes each joint by one lumped error: no kind of error is called missing,
    and a part remains that no remedy removes.
    """
    verdict, left = check_figures(small(EXAMPLES / "paper" / "z-arm-lumped.toml"))
    assert verdict.endswith("Not described, so taken as perfect: base tilt.")
    assert f"a controller that knows them leaves {length(left['load compensated'])}." in verdict
    assert " with " not in verdict.partition("leaves")[2]


def test_an_overloaded_drive_is_a_condition_of_the_answer(tmp_path):
    """With three times the payload joint A is overloaded: the answer holds only if its drive
    does.
    """
    study = small(z_arm(tmp_path, 'mass = "5 kg"', 'mass = "15 kg"'), poses=16, robots=32)
    verdict, _ = check_figures(study)
    assert verdict.startswith(
        "If the overloaded drive of A holds, expect 95 % of positions within "
    )
    assert "joint A is overloaded" in study.sheet.warnings[0]
    assert re.search(r"A holds \d+ N m, 1\d\d % of rated", first_screen(study.sheet))
    analytic = lostmotion.study(tmp_path / "z.toml", 8, method="analytic").sheet.verdict
    assert analytic.startswith("If the overloaded drive of A holds, expect 95 %")


UNRATED = """
name = "two drives"
[payload]
mass = "5 kg"
[[joints]]
name = "waist"
type = "revolute"
axis = "z"
limits = ["-90 deg", "90 deg"]
gearbox = "RV-40E-121"
link = { length = "200 mm", direction = "z", rigid = true }
[[joints]]
name = "shoulder"
type = "revolute"
axis = "y"
limits = ["-90 deg", "90 deg"]
gearbox = "RV-40E-121"
link = { length = "400 mm", rigid = true }
[[joints]]
name = "elbow"
type = "revolute"
axis = "y"
limits = ["-90 deg", "90 deg"]
gearbox = { stiffness = "10 N m/arcmin", backlash = "1 arcmin" }
link = { length = "300 mm", rigid = true }
"""


def test_a_drive_without_a_rating_holds_a_load_all_the_same(tmp_path):
    """5 kg at 0.3 m are 14.7 N m: an unrated elbow holds them, at an unknown share of its rating;
    only the upright waist holds nothing.
    """
    path = tmp_path / "arm.toml"
    path.write_text(UNRATED, encoding="utf-8")
    drives = dict(small(path, poses=128, robots=8).sheet.brief)["Drives"]
    assert "waist holds no load" in drives
    assert re.search(r"elbow holds 14[.]\d N m, no rated torque stated", drives)
    path.write_text(
        UNRATED.replace('"RV-40E-121"', '{ stiffness = "10 N m/arcmin", backlash = "1 arcmin" }'),
        encoding="utf-8",
    )
    drives = dict(small(path, poses=8, robots=8).sheet.brief)["Drives"]
    assert re.fullmatch(
        r"At the poses studied shoulder holds [\d.]+ N m, elbow [\d.]+ N m, no rated torque stated[.]",
        drives,
    )


def test_upright_drives_hold_no_load():
    """On a level base no drive of a SCARA but its lift is loaded: no zero is printed as a share of
    a rating.
    """
    drives = dict(small(EXAMPLES / "scara.toml", poses=8, robots=8).sheet.brief)["Drives"]
    assert drives == (
        "At the poses studied the rated drives hold no load; lift holds 19.6 N, no rated "
        "torque stated."
    )


def test_one_pose_and_few_robots_promise_no_more_than_they_know():
    """One robot at one pose: the figures stand without intervals, and the best pose is the
    worst.
    """
    sheet = small(
        EXAMPLES / "z-arm.toml",
        poses=lostmotion.sample_poses(lostmotion.read(EXAMPLES / "z-arm.toml"), 8).q[:1],
        robots=1,
        visits=2,
    ).sheet
    assert sheet.verdict.startswith("Expect 95 % of positions within ")
    assert not any(word == "Where" for word, _ in sheet.brief)


def test_nothing_stated_predicts_nothing(tmp_path):
    """Errors that are stated as zero are no accuracy, and have neither bars nor a remedy."""
    sheet = small(
        arm_of(
            tmp_path,
            'lumped = { angle = "0 deg" }',
            'lumped = { angle = "0 deg" }',
            tolerance="0 mm",
        )
    ).sheet
    assert sheet.verdict.startswith("Every error that is described is zero")
    assert sheet.bars == ()


def test_without_sampling_the_remedy_is_in_root_mean_squares():
    """An analytic study names the root mean square that compensation leaves, with the figure of its
    table.
    """
    sheet = lostmotion.study(EXAMPLES / "planar-2r.toml", 64, method="analytic").sheet
    left = row_at(sheet.sections, "levels", "left_after_compensation_of_load_and_pose").cells[0]
    assert (f"a controller that knows them leaves {length(left.value)} r.m.s. of") in sheet.verdict
