"""What a controller and its exports refuse, and what they say of the arm that they rest on."""

from __future__ import annotations

import math
import shutil
import subprocess

import numpy as np
import pytest

import lostmotion
from lostmotion.errors import InputError, OutputExistsError
from lostmotion.laws.distributions import Normal, Uniform
from lostmotion.mechanism.calibration import known_streams
from tests.parts.random_arms import EXAMPLES

Z_ARM = EXAMPLES / "z-arm.toml"
ZERO = ("joints.A.encoder.zero", Normal())


@pytest.mark.parametrize(
    ("streams", "mean", "covariance", "said"),
    [
        ((ZERO,), [math.nan], [[0.0]], "finite"),
        ((ZERO,), [0.1, 0.2], [[0.0]], "one per stream"),
        ((ZERO,), [0.1], [[-1.0]], "negative variances"),
        ((ZERO, ZERO), [0.1, 0.1], np.zeros((2, 2)), "every stream once"),
        ((("joints.A.encoder.zzero", Normal()),), [0.1], [[0.0]], "joints.A.encoder.zero"),
        ((("joints.A.encoder.zero", Uniform()),), [0.1], [[0.0]], "the law"),
    ],
)
def test_estimates_that_no_robot_can_have_are_refused(streams, mean, covariance, said):
    """A number that is not finite would become a robot without errors; a misspelt draw would be no
    calibration at all.
    """
    with pytest.raises(InputError, match=said):
        lostmotion.controller(
            Z_ARM, calibration=lostmotion.Calibration(streams, np.array(mean), np.array(covariance))
        )


def test_the_draws_of_an_arm_are_known():
    """Every one of them may be estimated; the robot with all estimates at zero has no more scatter
    from robot to robot.
    """
    arm = lostmotion.read(Z_ARM)
    streams = known_streams(arm.terms)
    assert ZERO in streams
    nominal = lostmotion.Calibration(
        streams, np.zeros(len(streams)), np.zeros((len(streams), len(streams)))
    )
    q = np.zeros(len(arm.moving))
    whole, known = (
        lostmotion.controller(arm, calibration=each).predict(q).mean_square[0]
        for each in (None, nominal)
    )
    assert known < whole


def test_an_arm_without_errors_is_refused(tmp_path):
    """It would be a perfect arm: the sentence of a study, and nothing is written."""
    with pytest.raises(InputError, match="no error source is described"):
        lostmotion.controller(_undescribed(tmp_path))
    with pytest.raises(InputError, match="no error source is described"):
        lostmotion.export_c(_undescribed(tmp_path), out=tmp_path / "c")
    assert not (tmp_path / "c").exists()


def _undescribed(folder):
    path = folder / "bare.urdf"
    shutil.copy(EXAMPLES / "ur5e.urdf", path)
    return path


@pytest.mark.parametrize("payload", [-1.0, 0.0, math.nan, "10 m", "ten"])
def test_a_payload_that_is_none_is_refused(payload):
    """With the argument's name; text with a unit is read."""
    with pytest.raises(InputError, match="largest_payload"):
        lostmotion.controller(Z_ARM, largest_payload=payload)
    assert lostmotion.controller(Z_ARM, largest_payload="10 kg").tables.valid.payload == 10.0


def test_three_passes_are_refused():
    """There are one or two."""
    model = lostmotion.controller(Z_ARM)
    with pytest.raises(ValueError, match="passes is 3"):
        model.compensate(np.zeros(5), passes=3)


def test_an_export_says_what_it_rests_on(tmp_path):
    """Assumed values and overloaded drives, as a study does, in the answer and in the README of the
    model.
    """
    heavy = tmp_path / "heavy.toml"
    heavy.write_text(
        Z_ARM.read_text(encoding="utf-8").replace('mass = "5 kg"', 'mass = "60 kg"', 1),
        encoding="utf-8",
    )
    found = lostmotion.export_c(heavy, out=tmp_path / "c")
    assert any("assumed" in each for each in found["remarks"])
    assert any("overloaded" in each for each in found["remarks"])
    text = (tmp_path / "c" / "README.md").read_text(encoding="utf-8")
    assert all(each in text for each in found["remarks"])


def test_only_an_export_is_replaced(tmp_path):
    """Not another project's folder, and no file that is not an FMU by its name."""
    arm = EXAMPLES / "planar-2r.toml"
    (tmp_path / "README.md").write_text("mine", encoding="utf-8")
    with pytest.raises(OutputExistsError, match="no export"):
        lostmotion.export_c(arm, out=tmp_path, force=True)
    assert (tmp_path / "README.md").read_text(encoding="utf-8") == "mine"
    with pytest.raises(InputError, match=r"\.fmu"):
        lostmotion.export_fmu(arm, out=tmp_path / "arm.toml", force=True)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
def test_names_cannot_break_the_sources(tmp_path):
    """Comment signs, umlauts and quotes in the names of arm and joints."""
    path = tmp_path / "odd.toml"
    text = Z_ARM.read_text(encoding="utf-8")
    assert 'name = "' in text
    head, _, rest = text.partition('name = "')
    path.write_text(f'{head}name = "a /* b */ Ärmchen ??/ {rest}', encoding="utf-8")
    lostmotion.export_c(path, out=tmp_path / "c")
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Isrc", "-c"]
    done = subprocess.run(
        ["gcc", *flags, "src/lm_model.c", "-o", "model.o"],
        cwd=tmp_path / "c",
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
