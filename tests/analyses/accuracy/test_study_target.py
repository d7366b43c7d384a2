"""The share of positions of a study that are within a target."""

import json

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.error_bins import bin_edges
from lostmotion.errors import InputError
from lostmotion.reporting.layout import row_at
from tests.parts.random_arms import EXAMPLES
from tests.reporting.first_screen import first_screen

TARGET = "0.8 mm"
LENGTH = "0.2 mm"  # some positions of the planar arm are within it


def test_the_share_within_the_target_is_that_of_all_samples(tmp_path):
    """Counted again from the histogram of all samples; printed with its interval, in the zone as
    well, and written to result.json.
    """
    study = lostmotion.study(
        EXAMPLES / "planar-2r.toml", 64, 100, 4, target=LENGTH, zone="x 0.2..0.8 m"
    )
    hist = study.sampled.replicate_hist.sum(axis=0)
    counted = hist[: int(np.searchsorted(bin_edges(), 0.2e-3))].sum() / hist.sum()
    figure = row_at(study.sheet.sections, "error", "within_the_target").cells[0]
    assert figure.value == pytest.approx(counted, abs=0.002)  # of one bin
    assert figure.low < figure.value < figure.high
    assert f"{figure} ({figure.interval}) of positions are within {LENGTH}." in " ".join(
        first_screen(study.sheet).split()
    )
    study.report(tmp_path / "out")
    written = json.loads((tmp_path / "out" / "result.json").read_text(encoding="utf-8"))["figures"]
    assert written["error"]["within_the_target"]["value"] == pytest.approx(figure.value)
    assert set(written["zone_1"]["within_the_target"]) == {"in_the_zone", "whole_workspace"}
    assert "target 0.2" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_of_an_arm_that_is_described_in_part_the_share_is_an_upper_bound():
    """Missing errors can only make positions miss the target."""
    joint = {"type": "revolute", "axis": "z", "limits": (-2, 2), "link": {"length": "400 mm"}}
    arm = lostmotion.Arm.model_validate(
        {
            "name": "half",
            "joints": [
                {**joint, "name": "A", "encoder": {"noise": "5 arcmin"}},
                {**joint, "name": "B", "axis": "y"},
            ],
        }
    )
    assert "At most " in dict(lostmotion.study(arm, 64, 50, 4, target=TARGET).sheet.brief)["Target"]


@pytest.mark.parametrize(
    ("target", "found"), [("1 kg", "1 kg"), ("-1 mm", "-1 mm"), ("1", "without a unit")]
)
def test_a_target_is_a_length_above_zero(target, found):
    """Another unit, no unit and a negative length are refused with an example."""
    with pytest.raises(InputError, match="target") as raised:
        lostmotion.study(EXAMPLES / "z-arm.toml", 8, 2, target=target)
    assert found in str(raised.value)
    assert "0.5 mm" in str(raised.value)


def test_a_share_is_counted_from_robots():
    """Without sampling there is none to count: the message names the method that has them."""
    with pytest.raises(InputError, match="both"):
        lostmotion.study(EXAMPLES / "z-arm.toml", 8, method="analytic", target=TARGET)
