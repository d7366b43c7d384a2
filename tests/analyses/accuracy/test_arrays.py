"""The labelled arrays of a study without sampling, by themselves and beside those of Monte
Carlo.
"""

from pathlib import Path

import numpy as np
import pint
import pytest
import xarray
from typer.testing import CliRunner

import lostmotion
from lostmotion.cli import app

ARM = Path(__file__).parents[3] / "examples" / "planar-2r.toml"
ZONE = "x 0.1..0.6 m"


@pytest.fixture(scope="module")
def arm():
    """Read an arm of two joints."""
    return lostmotion.read(ARM)


@pytest.fixture(scope="module")
def summed(arm):
    """Study it without sampling, in a zone too."""
    return lostmotion.study(arm, 64, method="analytic", zone=ZONE)


def test_units_are_ones_that_readers_of_units_know(summed):
    """Pint reads every unit; joint values have one where all joints turn, and none where one
    slides, but their name says which is which.
    """
    units = pint.UnitRegistry()
    data = summed.arrays()
    assert all(
        units.parse_units(values.attrs["units"]) is not None for values in data.data_vars.values()
    )
    assert data.q.attrs["units"] == "rad"
    joint = {
        "type": "revolute",
        "axis": "z",
        "limits": (-1.0, 1.0),
        "link": {"tip": {"xyz": (0.3, 0.0, 0.0)}},
        "lumped": {"angle": 1e-4},
    }
    slide = {
        "type": "prismatic",
        "axis": "z",
        "limits": (0.0, 0.1),
        "link": {"tip": {"xyz": (0.0, 0.0, 0.1)}},
        "lumped": {"offset": 1e-5},
    }
    arm = lostmotion.Arm.model_validate(
        {"name": "two", "joints": [{"name": "turn", **joint}, {"name": "slide", **slide}]}
    )
    q = lostmotion.study(arm, 8, method="analytic").arrays().q
    assert "units" not in q.attrs
    assert q.attrs["long_name"] == "joint values: rad where joint_unit is rad, m where it is m"
    assert q.joint_unit.values.tolist() == ["rad", "m"]


def test_every_pose_has_its_figures_without_sampling(summed):
    """Mean, deviation, quantiles, their uncertainty, mean vector and covariance of each pose, with
    units and names, are those of the study.
    """
    data, found = summed.arrays(), summed.analytic
    assert all(
        values.attrs["units"] and values.attrs["long_name"] for values in data.data_vars.values()
    )
    assert data.level.values.tolist() == [0.5, 0.95, 0.99, 0.997]
    for name, values in (
        ("error_mean", found.mean),
        ("error_mean_uncertainty", found.mean_uncertainty),
        ("error_standard_deviation", found.deviation),
        ("error_standard_deviation_uncertainty", found.deviation_uncertainty),
        ("error_quantile", found.quantiles),
        ("error_quantile_uncertainty", found.quantiles_uncertainty),
        ("bias", found.bias),
        ("covariance", found.covariance),
        ("worst_case", found.worst),
        ("root_sum_square", found.rss),
        ("q", summed.poses.q),
    ):
        np.testing.assert_array_equal(data[name].values, values)
    trace = (
        data.covariance.sel(axis="x", with_axis="x")
        + data.covariance.sel(axis="y", with_axis="y")
        + data.covariance.sel(axis="z", with_axis="z")
    )
    np.testing.assert_allclose(data.error_rms**2, (data.bias**2).sum("axis") + trace, rtol=1e-12)
    np.testing.assert_array_equal(data.zone_1_error_mean.values, summed.zones[0].analytic.mean)
    assert (data.zone_1_tool.sel(axis="x") <= 0.6).all()


def test_a_study_by_both_routes_holds_both_at_each_pose(arm, summed):
    """Beside each pose's samples lie its figures without sampling, in the zone too, and at most
    poses each lies in the other's interval.
    """
    data = lostmotion.study(arm, 64, robots=200, visits=3, method="both", zone=ZONE).arrays()
    for key in ("", "zone_1_"):
        apart = (
            np.abs(data[f"{key}analytic_error_mean"] - data[f"{key}error_mean"])
            / data[f"{key}error_mean_half_interval"]
        )
        assert float((apart <= 1).mean()) > 0.5
        alone = summed.arrays()
        np.testing.assert_array_equal(
            data[f"{key}analytic_covariance"].values, alone[f"{key}covariance"].values
        )
        np.testing.assert_allclose(
            data[f"{key}analytic_bias"].values, data[f"{key}bias"].values, rtol=0, atol=1e-15
        )


def test_a_run_without_sampling_writes_its_arrays(tmp_path):
    """`run --method analytic` leaves report.html, result.json and arrays.nc, as its help says, and
    the page links them.
    """
    out = tmp_path / "out"
    told = CliRunner().invoke(
        app,
        ["run", str(ARM), "--poses", "8", "--method", "analytic", "--out", str(out), "--quiet"],
    )
    assert told.exit_code == 0, told.output
    assert sorted(path.name for path in out.iterdir()) == [
        "arrays.nc",
        "report.html",
        "result.json",
    ]
    with xarray.open_dataset(out / "arrays.nc", engine="scipy") as read:
        assert read.covariance.shape == (8, 3, 3)
    assert 'href="arrays.nc"' in (out / "report.html").read_text(encoding="utf-8")
