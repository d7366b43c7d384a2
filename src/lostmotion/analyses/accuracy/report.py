"""The report of a study: a folder with report.html, result.json and arrays.nc."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.analyses.accuracy.tables.study import sheet
from lostmotion.reporting.folder import refuse_existing, write_whole
from lostmotion.reporting.page import contents

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import xarray

    from lostmotion.analyses.accuracy.answer import Answer
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet


def write_folder(study: Answer, out: str | Path, *, force: bool = False) -> Path:
    """Where do the results lie? Writes report.html, result.json and arrays.nc into the folder `out`, whole or not at all; gives the folder.

    Missing parents are made. With `force` an earlier output folder is replaced, once the new one is complete. The same study gives the same bytes.
    Raises OutputExistsError as `refuse_existing`, LostmotionError where the folder cannot be written; then nothing is left behind.
    """
    refuse_existing(out, force=force)
    return write_whole(_contents(study), out, force=force)


def write_analytic(sheet: Sheet, drawn: Sequence[Plot], arrays: xarray.Dataset, out: str | Path, *, force: bool = False) -> Path:
    """Where do the results without sampling lie? Writes the same files into the folder `out`; errors as `write_folder`."""
    refuse_existing(out, force=force)
    return write_whole({**contents(sheet, drawn), "arrays.nc": bytes(arrays.to_netcdf(engine="scipy"))}, out, force=force)


def _contents(study: Answer) -> dict[str, bytes]:
    from lostmotion.analyses.accuracy.arrays import dataset
    from lostmotion.analyses.accuracy.plots.study import plots

    return {**contents(sheet(study), plots(study)), "arrays.nc": bytes(dataset(study).to_netcdf(engine="scipy"))}
