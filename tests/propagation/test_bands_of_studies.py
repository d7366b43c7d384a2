"""Bands of a study: how far its figures depend on values that are only known to lie in a range."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.accuracy.tables.study import sheet
from lostmotion.band import Band
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.error_model.poses import sample_poses
from lostmotion.io.native import read_arm
from lostmotion.parts.bands import influence
from lostmotion.propagation.montecarlo.bands import DRAWS, bands

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "bands of a study",
        (
            "a deflection in proportion to 1/E, uniform in the logarithm: its quantiles; noise of "
            "an encoder does not widen"
        ),
        "1e-3; 1e-6",
        "propagation/montecarlo/bands.py",
    ),
)

STATED = """
name = "cantilever"

[payload]
mass = "{mass} kg"

[[joints]]
name = "A"
type = "revolute"
axis = "z"
limits = ["-90 deg", "90 deg"]
encoder = {{ noise = "{noise}" }}

[joints.link]
length = "{length} mm"
section = {{ kind = "tube", outer = "20 mm", wall = "2 mm" }}
material = "print"

[materials.print]
young = "{young}"
poisson = 0.36
density = "1 kg/m^3"
"""


def read(tmp_path, *, young="1.3 .. 3.0 GPa", noise="0 arcmin", mass=1.0, length=400):
    """Return an arm of one link that carries a payload, with a Young's modulus that is known as a
    range.
    """
    file = tmp_path / "arm.toml"
    file.write_text(
        STATED.format(young=young, noise=noise, mass=mass, length=length), encoding="utf-8"
    )
    return read_arm(file)


def test_an_error_in_proportion_to_a_compliance_has_its_quantiles(tmp_path):
    """A tip sags by F l^3/(3 E I): its 5th and 95th percentile are those of 1/E, uniform in the
    logarithm, whatever the other figures.
    """
    arm = read(tmp_path)
    found = bands(arm, sample_poses(arm, 64), 8, 2, 1)
    low, high = found.band("mean", 1.0)
    span = math.log(3.0 / 1.3)
    assert low == pytest.approx(math.exp(-0.45 * span), rel=1e-3)
    assert high == pytest.approx(math.exp(0.45 * span), rel=1e-3)
    assert found.influence("mean") == {"materials.print.young": pytest.approx(1.0)}


def test_a_middle_changes_nothing_and_a_known_value_has_no_band(tmp_path):
    """An arm with the geometric mean of a range has the figures of the arm with the range."""
    arm, poses = read(tmp_path), sample_poses(read(tmp_path), 64)
    known = read(tmp_path, young=f"{math.sqrt(1.3 * 3.0)} GPa")
    assert bands(known, poses, 8, 2, 1) is None
    assert pose_matrix(arm, poses.q).local == pytest.approx(
        pose_matrix(known, poses.q).local, rel=1e-12
    )


def test_errors_between_visits_are_not_widened_by_ignorance_of_a_spring(tmp_path):
    """The noise of an encoder alone makes RP: the same in every draw of a modulus."""
    arm = read(tmp_path, noise="1 arcmin")
    found = bands(arm, sample_poses(arm, 64), 64, 8, 1)
    low, high = found.band("rp_any_p95", 1.0)
    assert low == pytest.approx(1.0, rel=1e-6)
    assert high == pytest.approx(1.0, rel=1e-6)
    assert found.influence("rp_any_p95")["materials.print.young"] == 0


def test_the_sheet_has_band_and_interval_apart(tmp_path):
    """The interval counts robots and poses and does not change; the band is a table of its own,
    named in headline, card and result.
    """
    study = lostmotion.study(read(tmp_path, noise="1 arcmin"), 64, 16, 4)
    known = lostmotion.study(
        read(tmp_path, young=f"{math.sqrt(1.3 * 3.0)} GPa", noise="1 arcmin"), 64, 16, 4
    )
    found, plain = sheet(study), sheet(known)
    by_key = {section.key: section for section in found.sections}
    rows = {row.label: row.cells for row in by_key["bands"].rows}
    assert [figure.value for figure in rows["mean"]] == sorted(
        figure.value for figure in rows["mean"]
    )
    assert by_key["ranges"].rows[0].label == "materials.print.young"
    assert "bands" not in {section.key for section in plain.sections}
    for section in ("error", "iso9283"):
        for mine, theirs in zip(
            by_key[section].rows,
            next(each.rows for each in plain.sections if each.key == section),
            strict=True,
        ):
            assert mine.cells[0].low == pytest.approx(theirs.cells[0].low, rel=1e-9, nan_ok=True)
    assert "materials.print.young" in found.verdict
    assert any("ranges" in card.quiet for card in found.cards)
    assert found.facts["ranges"] == [
        {"key": "materials.print.young", "low": 1.3e9, "high": 3e9, "law": "log-uniform"}
    ]


def test_influence_of_independent_ranges_adds_up_to_one():
    """A sum of two ranges, one three times as wide, follows nine tenths of its variance from that
    one.
    """
    rng = np.random.default_rng(3)
    shares = np.column_stack([rng.permutation(DRAWS * 8), rng.permutation(DRAWS * 8)]) / (DRAWS * 8)
    wide, narrow = (
        np.array([band.at(share) for share in column])
        for band, column in zip((Band(0, 3), Band(0, 1)), shares.T, strict=True)
    )
    first, second = influence(shares, wide + narrow)
    assert first == pytest.approx(0.9, abs=0.03)
    assert second == pytest.approx(0.1, abs=0.03)
