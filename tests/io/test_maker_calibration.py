"""A maker's calibration as errors of an arm."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.errors import InputError
from lostmotion.mechanism.state import state_of
from lostmotion.spatial import exp, inverse

ARM = Path(__file__).parents[2] / "examples" / "calibration" / "ur5.toml"
# The calibration.conf of a UR5 (github.com/ros-industrial-attic/ur_modern_driver, issue 179): its
# lengths of hundreds of metres cancel, since axes 2, 3 and 4 are nearly parallel.
CONF = """[mounting]
delta_theta = [2.07750978653505926e-05, 0.96821571555565844, -1.85685385014877657,
  0.888647901450376643, 5.66106814887767484e-05, -7.46310764096455082e-05]
delta_a = [0.000393621049984383038, 0.184093300397451837, 0.14493953300732923,
  -6.43297403642304399e-05, 7.76709040084077299e-06, 0]
delta_d = [4.00263097760228392e-05, 278.244144925623573, -183.695513914913732,
  -94.5471513669751289, 0.000304782681775556119, 0.000123737941387466743]
delta_alpha = [-0.000271624944216508624, 0.00125856505456124258, -0.00322052070697146503,
  0.00065153016530383745, -0.00058700465721117645, 0]
"""


def test_lengths_of_hundreds_of_metres_are_small_screws(tmp_path):
    """Offsets of 278 m of the maker's table are tilts below 4 mrad and offsets below 3 mm, and the
    arm then moves as the maker's chain to 0.1 µm.
    """
    path = tmp_path / "calibration.conf"
    path.write_text(CONF)
    found = lostmotion.calibrate(ARM, maker=path)
    robot = [each for each in found.errors if not each.frame]
    assert max(abs(each.value) for each in robot if each.unit == "rad") < 4e-3
    assert max(abs(each.value) for each in robot if each.unit == "m") < 3e-3
    assert found.left < 1e-7
    assert 1.5e-3 < found.before < 3e-3  # two to three millimetres, as the issue reports


def test_frames_of_a_driver_are_read_as_well(tmp_path):
    """The YAML of a ROS driver has a frame before each joint, here of a robot with known errors,
    whose tool point the calibrated arm reaches.
    """
    arm, chance = lostmotion.read(ARM), np.random.default_rng(2)
    at = state_of(arm, np.zeros((1, 6))).frames[:, 0]
    places = [0, *arm.tree.moved]
    lines, frames = ["kinematics:", "  hash: calib_1"], []
    for before, after in itertools.pairwise(places):
        frame = inverse(at[before]) @ at[after] @ exp(chance.normal(0, 5e-4, 6))
        frames.append(frame)
        pitch = np.arcsin(-frame[2, 0])
        roll, yaw = np.arctan2(frame[2, 1], frame[2, 2]), np.arctan2(frame[1, 0], frame[0, 0])
        numbers = (*frame[:3, 3], roll, pitch, yaw)
        keys = ("x", "y", "z", "roll", "pitch", "yaw")
        pairs = zip(keys, numbers, strict=True)
        lines += [f"  joint_{after}:", *(f"    {key}: {value!r}" for key, value in pairs)]
    path = tmp_path / "calibration.yaml"
    path.write_text("\n".join(line.replace("np.float64(", "").rstrip(")") for line in lines))
    found = lostmotion.calibrate(ARM, maker=path)
    assert found.left < 1e-6
    assert found.before > 1e-4


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("delta_theta = [0, 0]", "2 numbers"),
        ("kinematics:\n  shoulder:\n    x: 0\n", "0 frames"),
        ("delta_theta = [a, b]", "numbers"),
    ],
)
def test_other_files_are_refused(text, wanted, tmp_path):
    """A file without a row for each joint is refused with what was found."""
    path = tmp_path / "other.conf"
    path.write_text(text)
    with pytest.raises(InputError, match=wanted):
        lostmotion.calibrate(ARM, maker=path)
