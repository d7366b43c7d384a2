"""The file of a calibration: what it states reaches the exports, and every mistake in it has a
message that says where.
"""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import lostmotion
from lostmotion.analyses.export.model import input_hash
from lostmotion.cli import app
from lostmotion.errors import InputError
from lostmotion.laws.distributions import Cosine, Normal, Sine
from tests.parts.random_arms import EXAMPLES

Z_ARM = EXAMPLES / "z-arm.toml"
ZERO = '[[estimates]]\ndraw = "joints.A.encoder.zero"\nmean = 0.7\n'
HARMONIC = "joints.A.gearbox.transmission error 1"
WAVES = "".join(
    f'[[estimates]]\ndraw = "{HARMONIC}"\nphase = "{phase}"\nmean = {mean}\n'
    for phase, mean in (("cosine", 0.9), ("sine", -0.3))
)


def written(folder, text):
    """Return the path of a calibration file with this text."""
    path = folder / "robot-17.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_file_states_what_python_states(tmp_path):
    """Three estimates with a covariance, and one with a deviation: the tables of the controller are
    those of the same calibration in Python.
    """
    covariance = np.diag([0.01, 0.02, 0.02])
    covariance[0, 1] = covariance[1, 0] = 0.003
    streams = (("joints.A.encoder.zero", Normal()), (HARMONIC, Cosine()), (HARMONIC, Sine()))
    stated = {
        f"covariance = {covariance.tolist()}\n{ZERO}{WAVES}": lostmotion.Calibration(
            streams, np.array([0.7, 0.9, -0.3]), covariance
        ),
        f"{ZERO}deviation = 0.1\n": lostmotion.Calibration(
            streams[:1], np.array([0.7]), np.array([[0.1**2]])
        ),
    }
    for text, known in stated.items():
        found, expected = (
            lostmotion.controller(Z_ARM, calibration=each).predict(np.zeros(5))
            for each in (written(tmp_path, text), known)
        )
        np.testing.assert_array_equal(found.screw, expected.screw)
        np.testing.assert_array_equal(found.covariance, expected.covariance)


def test_a_calibration_reaches_the_export_from_the_command_line(tmp_path):
    """The hash of the input is that of the calibrated robot, and the README says that the model is
    of one robot.
    """
    path = written(tmp_path, f"{ZERO}deviation = 0.1\n")
    printed = CliRunner().invoke(
        app,
        [
            "export",
            "c",
            str(Z_ARM),
            "-o",
            str(tmp_path / "c"),
            "--calibration",
            str(path),
            "--json",
        ],
    )
    assert printed.exit_code == 0, printed.output
    known = lostmotion.Calibration(
        (("joints.A.encoder.zero", Normal()),), np.array([0.7]), np.array([[0.1**2]])
    )
    one = lostmotion.read(Z_ARM).calibrated(known)
    assert json.loads(printed.stdout)["sha256"] == input_hash(one)
    in_words = (
        CliRunner()
        .invoke(
            app,
            [
                "export",
                "fmu",
                str(Z_ARM),
                "-o",
                str(tmp_path / "z.fmu"),
                "--calibration",
                str(path),
            ],
        )
        .stdout
    )
    assert f"File: {tmp_path / 'z.fmu'}" in in_words
    assert f"SHA-256 of the input: {json.loads(printed.stdout)['sha256'][:16]}" in in_words
    assert "one calibrated robot, with 1 estimate" in (tmp_path / "c" / "README.md").read_text(
        encoding="utf-8"
    )


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", ["estimates"]),
        ("estimates = 3", ["robot-17.toml:1", "estimates"]),
        (ZERO, ["estimates[0].deviation", "deviation = 0.1"]),
        (f"{ZERO}deviation = -0.1", ["robot-17.toml:4", "-0.1", "from 0 to 1000"]),
        (ZERO.replace("0.7", "nan") + "deviation = 0.1", ["robot-17.toml:3", "mean"]),
        (ZERO.replace("0.7", '"0.7"') + "deviation = 0.1", ["robot-17.toml:3", "mean"]),
        (
            ZERO.replace("zero", "zzero") + "deviation = 0.1",
            ["robot-17.toml:2", "did you mean 'joints.A.encoder.zero'"],
        ),
        (f"{ZERO}deviation = 0.1\ndrift = 1", ["robot-17.toml:5", "drift"]),
        (f'{ZERO}deviation = 0.1\nphase = "sine"', ["robot-17.toml:5", "no harmonic"]),
        (
            f'[[estimates]]\ndraw = "{HARMONIC}"\nmean = 1\ndeviation = 0',
            ["estimates[0].phase", "sine or cosine"],
        ),
        (f"{ZERO}deviation = 0.1\n{ZERO}deviation = 0.1\n", ["robot-17.toml:6", "every draw once"]),
        (f"covariance = [[0.01]]\n{ZERO}deviation = 0.1", ["no deviation beside covariance"]),
        (f"covariance = [[0.01, 0.0]]\n{ZERO}", ["robot-17.toml:1", "1 rows of 1 numbers"]),
        (f"covariance = []\n{ZERO}", ["robot-17.toml:1", "1 rows of 1 numbers"]),
        (f"covariance = [[-0.01]]\n{ZERO}", ["robot-17.toml:1", "negative variances"]),
        (f"covariance = [[0.01, 0.002], [0.001, 0.01]]\n{WAVES}", ["robot-17.toml:1", "symmetric"]),
        (f"covariance = [[1e999]]\n{ZERO}", ["robot-17.toml:1", "at most 1e+06"]),
        (f"{ZERO}deviation = 1e200", ["robot-17.toml:4", "1e+200"]),
        ("[[estimates]]\n" * 501, ["at most 500"]),
        ("a = " + "[" * 400 + "]" * 400, ["nested too deeply"]),
    ],
)
def test_a_mistake_has_a_message_with_its_place(tmp_path, text, said):
    """File, line or key, what was found and what belongs there."""
    with pytest.raises(InputError) as refused:
        lostmotion.controller(Z_ARM, calibration=written(tmp_path, text))
    message = str(refused.value)
    assert "robot-17.toml" in message
    for each in said:
        assert each in message, message


def test_all_mistakes_are_listed_at_once(tmp_path):
    """A misspelt draw, a missing phase and a missing deviation in one file; what is neither a
    calibration nor a path is refused.
    """
    text = (
        ZERO.replace("zero", "zzero") + "deviation = 0.1\n" + WAVES.replace('phase = "sine"\n', "")
    )
    with pytest.raises(InputError) as refused:
        lostmotion.controller(Z_ARM, calibration=written(tmp_path, text))
    assert len(refused.value.problems) == 4
    with pytest.raises(InputError, match="calibration"):
        lostmotion.export_c(Z_ARM, out=tmp_path / "c", calibration=3)
    with pytest.raises(InputError, match=r"absent\.toml"):
        lostmotion.export_c(Z_ARM, out=tmp_path / "c", calibration=tmp_path / "absent.toml")
