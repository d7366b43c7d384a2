"""The simulated measurements beside the examples of calibration."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import lostmotion
from lostmotion.io.measured.calibration_visits import read_calibration_visits
from tests.calibration.ur5_grid import EXAMPLES

FOLDER = EXAMPLES / "calibration"
NUMBER = re.compile(r"-?\d+\.\d+")


def test_the_readings_are_what_their_script_writes():
    """Row by row, each reading to the last digit printed: else run examples/calibration/make.py."""
    written = subprocess.run(
        [sys.executable, FOLDER / "make.py"], capture_output=True, text=True, check=True
    ).stdout
    stored = (FOLDER / "printed-dial.csv").read_text("utf-8")
    assert NUMBER.sub("#", written).split() == NUMBER.sub("#", stored).split()
    assert list(map(float, NUMBER.findall(written))) == pytest.approx(
        list(map(float, NUMBER.findall(stored))), abs=0.011
    )


def test_a_dial_gauge_calibrates_a_printed_arm():
    """With the side of arrival the error at unused readings falls by a third at least; without it
    half as much again remains.
    """
    arm = lostmotion.read(EXAMPLES / "printed-hobby-arm.toml")
    visits = read_calibration_visits(FOLDER / "printed-dial.csv", arm)
    answer = lostmotion.calibrate(arm, visits, terms="geometry")
    climb = answer.robot.climb
    left = climb.random.mean
    assert climb.random.mean < 2 / 3 * climb.before.mean

    blind = replace(visits, approach=np.zeros_like(visits.q))
    climb = lostmotion.calibrate(arm, blind, terms="geometry").robot.climb
    assert climb.random.mean > 1.5 * left
