"""Arrays with the names of their axes, units and meanings: as data of xarray, and as a NetCDF
file.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    import xarray


class LabelledArrays(NamedTuple):
    """What a dataset of xarray is made of.

    data         names of axes, values and attributes of each array, by name
    coordinates  the same of arrays that label an axis, or values alone where the name is the axis
    attributes   of the whole: texts and numbers
    """

    data: dict[str, Any]
    coordinates: dict[str, Any]
    attributes: dict[str, Any]

    def dataset(self) -> xarray.Dataset:
        """Return them as data of xarray."""
        import xarray

        return xarray.Dataset(*self)

    def netcdf(self) -> bytes:
        """Return the content of a NetCDF 3 file, of the same bytes as xarray's, which would first
        load pandas, pint, and dask where it is installed.
        """
        from scipy.io import netcdf_file

        content = io.BytesIO()
        sizes: dict[str, int] = {}
        file = netcdf_file(content, "w", version=2)
        for key, value in self.attributes.items():
            setattr(file, key, _encoded(value))
        written = list(self._written())
        for _, axes, values, _ in written:
            sizes |= dict(zip(axes, values.shape, strict=True))
        for axis, size in sizes.items():
            file.createDimension(axis, size)
        for name, axes, values, attributes in written:
            variable = file.createVariable(name, values.dtype, axes)
            for key, value in attributes.items():
                setattr(variable, key, _encoded(value))
            variable[:] = values
        file.flush()
        return content.getvalue()

    def _written(self) -> Iterator[tuple[str, tuple[str, ...], np.ndarray, dict[str, Any]]]:
        """Yield name, axes, values and attributes of each array as a file holds them: texts as
        bytes in UTF-8, NaN for what is missing.
        """
        labels = {
            name: axes_of(given[0])
            for name, given in self.coordinates.items()
            if isinstance(given, tuple) and name not in axes_of(given[0])
        }
        for name, given in {**self.data, **self.coordinates}.items():
            axes, listed, attributes = (
                (*given, {})[:3] if isinstance(given, tuple) else (name, given, {})
            )
            axes, values, attributes = axes_of(axes), np.asarray(listed), dict(attributes)
            own = (
                []
                if name in {*labels, *axes}
                else sorted(key for key, along in labels.items() if {*along} <= {*axes})
            )
            if own:
                attributes["coordinates"] = " ".join(own)
            if values.dtype.kind == "f":
                attributes["_FillValue"] = values.dtype.type(np.nan)
            if values.dtype.kind == "U":
                coded = np.array([text.encode() for text in values.tolist()])
                axes = (*axes, f"string{coded.dtype.itemsize}")
                values = coded.view("S1").reshape(len(coded), -1)
                attributes["_Encoding"] = "utf-8"
            yield name, axes, _encoded(values), attributes


def axes_of(axes: str | tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of axes, of which one alone may be a text."""
    return (axes,) if isinstance(axes, str) else tuple(axes)


def _encoded(value: Any) -> Any:  # noqa: ANN401 - a text or a number
    """Return a text in UTF-8, whole numbers in 32 bits, since NetCDF 3 has no longer ones, and
    anything else as it is. Raises ValueError where 32 bits do not hold them.
    """
    if isinstance(value, str):
        return value.encode()
    numbers = np.atleast_1d(value)
    if numbers.dtype != np.int64:
        return numbers
    short = numbers.astype(np.int32)
    if not np.array_equal(short, numbers):
        raise ValueError(f"{numbers.max()} is no number of 32 bits")
    return short
