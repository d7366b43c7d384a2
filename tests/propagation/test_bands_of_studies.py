"""Bands of a study: how far its figures depend on values that are only known to lie in a range."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.accuracy.page import sheet
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
            "a cantilever that carries its load where it stands, 1/E uniform in the logarithm: "
            "quantiles of its deflection, and of the radius at which its encoder's noise acts"
        ),
        "1e-4",
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


def bent(share: float) -> tuple[float, float]:
    """Return how far the tip of this cantilever sags and its distance from the joint's axis, m.

    share  of a Young's modulus that is uniform in the logarithm from 1.3 to 3.0 GPa

    The payload bends the deflected tip by the part of its weight that is normal to it,
    F cos(angle), and the tip moves along the arc of its twist; the tube's stretch and shear are far
    below a thousandth of the sag.
    """
    young, length, force = 1.3e9 * (3.0 / 1.3) ** share, 0.4, 9.80665
    slope = force * length**2 / (2 * young * math.pi / 64 * (0.02**4 - 0.016**4))
    angle = 0.0
    for _ in range(30):
        angle = slope * math.cos(angle)
    arc = 2 / 3 * length  # l^3/(3 E I) over l^2/(2 E I), the radius of the arc
    return 2 * arc * math.sin(angle / 2), length - arc * (1 - math.cos(angle))


@pytest.mark.usual_counts
def test_the_error_of_a_cantilever_has_the_quantiles_of_its_sag(tmp_path):
    """The 5th and 95th percentile of a deflection are those at the percentiles of the modulus that
    makes it, whatever the other figures.
    """
    arm = read(tmp_path)
    found = bands(arm, sample_poses(arm, 64), 8, 2, 1)
    low, high = found.band("mean", bent(0.5)[0])
    assert low == pytest.approx(bent(0.95)[0], rel=1e-4)
    assert high == pytest.approx(bent(0.05)[0], rel=1e-4)
    assert found.influence("mean") == {"materials.print.young": pytest.approx(1.0)}


def test_a_middle_changes_nothing_and_a_known_value_has_no_band(tmp_path):
    """An arm with the geometric mean of a range has the figures of the arm with the range."""
    arm, poses = read(tmp_path), sample_poses(read(tmp_path), 64)
    known = read(tmp_path, young=f"{math.sqrt(1.3 * 3.0)} GPa")
    assert bands(known, poses, 8, 2, 1) is None
    assert pose_matrix(arm, poses.q).local == pytest.approx(
        pose_matrix(known, poses.q).local, rel=1e-12
    )


def test_errors_between_visits_are_widened_by_the_radius_of_the_tool_alone(tmp_path):
    """The noise of an encoder alone makes RP: in every draw of a modulus that of the radius at
    which the sagging tool turns.
    """
    arm = read(tmp_path, noise="1 arcmin")
    found = bands(arm, sample_poses(arm, 64), 64, 8, 1)
    low, high = found.band("rp_any_p95", bent(0.5)[1])
    assert low == pytest.approx(bent(0.05)[1], rel=1e-4)
    assert high == pytest.approx(bent(0.95)[1], rel=1e-4)


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
