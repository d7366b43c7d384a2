"""Arrays with names, units and meanings, in memory and as files."""

from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.reporting.labelled_arrays import LabelledArrays

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize("method", ["montecarlo", "analytic", "both"])
def test_arrays_are_written_as_xarray_writes_them(method):
    """The file arrays.nc has the bytes of xarray's own `to_netcdf`: names, units, texts, labels of
    joints and missing values, in zones too.
    """
    found = lostmotion.study(EXAMPLES / "scara.toml", 16, 20, 3, method=method, zone="x 0..0.3 m")
    assert found.files()["arrays.nc"] == bytes(found.arrays().to_netcdf(engine="scipy"))


def test_a_map_is_written_as_xarray_writes_it():
    """So has that of a map, whose axes have values and units of their own."""
    found = lostmotion.map(EXAMPLES / "scara.toml", cell="0.1 m", poses=512)
    assert found.files()["arrays.nc"] == bytes(found.arrays().to_netcdf(engine="scipy"))


def test_a_number_that_the_format_does_not_hold_is_no_other_number():
    """NetCDF 3 has whole numbers of 32 bits: a larger one is an error, not another number."""
    arrays = LabelledArrays({"count": ("robot", np.array([2**40]))}, {}, {})
    with pytest.raises(ValueError, match="32 bits"):
        arrays.netcdf()
