"""The arms that ship as examples, and the catalogue behind them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.accuracy.page import sections
from lostmotion.catalogue import materials
from lostmotion.mechanism.state import state_of
from tests.io.conftest import EXAMPLES


def test_the_z_arm_moves_as_the_papers_equations_say():
    """Equation (1), with the sines that its third line must have, in interior angles q1 to q3 where
    180 degrees is straight.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    s, r, q0, lengths = 0.15, 0.35, math.radians(60), (0.3, 0.4, 0.4, 0.2)
    rng = np.random.default_rng(6)
    for omega, q1, q2, q3, roll in rng.uniform(-2, 2, (20, 5)):
        directions = (q0, q0 - q1 + math.pi, q0 - q1 + q2, q0 - q1 + q2 + q3 + math.pi)
        out = sum(length * math.cos(phi) for length, phi in zip(lengths, directions, strict=True))
        up = sum(length * math.sin(phi) for length, phi in zip(lengths, directions, strict=True))
        expected = [out * math.cos(omega) + s, out * math.sin(omega), up + r]
        q = [omega, math.pi - q1, q2 - math.pi, q3 - math.pi, roll]
        assert state_of(arm, np.array(q)).frames[-1, 0, :3, 3] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("name", ["z-arm.toml", "ur5e.urdf"])
def test_an_example_errs_by_about_a_millimetre_and_repeats_far_better(name):
    """What such arms do: uncompensated wind-up of about a millimetre, and hundredths from visit to
    visit.
    """
    arm = lostmotion.read(EXAMPLES / name)
    assert arm.notes == ()
    figures = {
        row.label: row.cells[0]
        for section in sections(lostmotion.study(arm, 64, 50, 10))
        for row in section.rows
    }
    found = (
        figures[f"{name}, mean over poses and robots"]
        for name in ("AP", "RP, any approach", "RP, ISO cycle")
    )
    accuracy, of_either_side, of_one_side = (figure.value for figure in found)
    assert 0.3e-3 < accuracy < 2e-3
    assert 10e-6 < of_either_side < 100e-6
    assert 0 < of_one_side < of_either_side / 2


def test_every_material_is_a_solid_with_a_source():
    """Known by name, in SI, each with the sources and the confidence of its values."""
    found = materials()
    assert found["steel"].young == pytest.approx(210e9)
    assert found["aluminium"].density == pytest.approx(2700)
    for material in found.values():
        assert 1e9 < material.young < 250e9
        assert 0.2 < material.poisson < (0.4 if material.shear_modulus is None else 0.9)
        assert 1000 < material.density < 8000
        assert "[M 9" in material.source
