"""Makers' own worked examples of wind-up and lost motion, through a whole arm file: name in the
catalogue, load on the joint, error at the joint.
"""

from __future__ import annotations

import numpy as np
import pytest

from lostmotion.io import read
from tests.parts.conditions import ARCMIN, local_screws

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "wind-up and lost motion of catalogue reducers",
        (
            "Harmonic Drive's worked example (HFUC-32-100, 60 N m); the RV makers' definition, "
            "through an arm file"
        ),
        "printed digits; 1e-9",
    ),
)


def error_under(tmp_path, reducer: str, torque: float) -> float:
    """Return the angle (rad) by which a joint with this reducer deviates under a torque on the
    tool, without scatter between visits.
    """
    (tmp_path / "arm.toml").write_text(
        f'name = "x"\ngravity = "0 m/s^2"\npayload = {{ moment = ["0 N m", "0 N m", '
        f'"{torque!r} N m"] }}\n'
        '[[joints]]\nname = "A"\ntype = "revolute"\nlimits = ["-90 deg", "90 deg"]\ngearbox = '
        f'"{reducer}"\n',
        encoding="utf-8",
    )
    arm = read(tmp_path / "arm.toml")
    found = local_screws(arm, np.zeros((1, 1)))
    return float(
        sum(
            screw[0, 2]
            for of, screw in found
            if of.owner == "joints.A.gearbox" and of.term.level == "design"
        )
    )


def test_harmonic_drives_example_of_the_torsion_angle(tmp_path):
    """HFUC-32-100 under 60 N m, between T1 and T2: 29/6.7e4 + 31/1.1e5 = 7.15e-4 rad = 2.5'.

    Source: Harmonic Drive, engineering data CSD-2A, 1019659 11/2014, p. 23; the same in CHA,
    1018854 12/2015, p. 68.
    """
    angle = error_under(tmp_path, "HFUC-32-100", 60.0)
    assert angle == pytest.approx(7.15e-4, abs=5e-7)
    assert angle / ARCMIN == pytest.approx(2.5, abs=0.05)


@pytest.mark.parametrize(
    ("torque", "by_rule"),
    [
        (20.0, 20 / 6.7e4),
        (29.0, 29 / 6.7e4),
        (108.0, 29 / 6.7e4 + 79 / 11e4),
        (150.0, 29 / 6.7e4 + 79 / 11e4 + 42 / 12e4),
    ],
)
def test_the_same_gear_below_and_above_its_zones(tmp_path, torque: float, by_rule: float):
    """The same source's rule in its other zones, and in the other direction."""
    assert error_under(tmp_path, "HFUC-32-100", torque) == pytest.approx(by_rule, rel=1e-12)
    assert error_under(tmp_path, "HFUC-32-100", -torque) == pytest.approx(-by_rule, rel=1e-12)


@pytest.mark.parametrize(
    ("reducer", "rated", "rigidity", "torque"),
    [
        ("RV-160E", 1568.0, 392.0, 1200.0),
        ("RV-42N", 412.0, 113.0, 412.0),
        ("RV-6E", 58.0, 20.0, 0.03 * 58.0),
    ],
)
def test_an_rv_stands_off_by_half_its_lost_motion_and_its_rigidity(
    tmp_path, reducer: str, rated: float, rigidity: float, torque: float
):
    """By the makers' definition: half the lost motion at 3 % of the rated torque, and from there (T
    - 3 %)/rigidity; RV-160E, 1200 N m: 3.44'.
    """
    lost_motion = 1.5 if reducer == "RV-6E" else 1.0
    by_rule = lost_motion / 2 + (torque - 0.03 * rated) / rigidity
    assert error_under(tmp_path, f"{reducer}-100", torque) / ARCMIN == pytest.approx(
        by_rule, rel=1e-9
    )
    if reducer == "RV-160E":
        assert by_rule == pytest.approx(3.44, abs=0.005)


def test_nabtescos_example_of_the_torsion_angle(tmp_path):
    """RV-160E under 1 300 N m, beyond the lost motion's range: 1/2 + (1300 - 47.0)/392 = 3.70'.

    Source: Nabtesco, Precision Reduction Gear RV, E series, "Calculation of torsion angle". Its
    other example, 30 N m within that range, lies on the straight line from no load to half the lost
    motion; here play and spring are apart, and the whole band is passed as soon as friction is.
    """
    assert error_under(tmp_path, "RV-160E-100", 1300.0) / ARCMIN == pytest.approx(3.70, abs=0.005)
