"""Search the catalogue."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

from lostmotion.analyses.arguments import reducers_of
from lostmotion.analyses.quantities import Amount
from lostmotion.analyses.result import Result
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from lostmotion.catalogue.gearbox_row import GearboxRow
    from lostmotion.reporting.sheet import Sheet


@question(folder="")
def catalog(
    name: Annotated[
        str | None,
        Argument(
            "One entry as a whole: a reducer with or without its ratio, a material, table of "
            "bearings, or preset."
        ),
    ] = None,
    *,
    kind: Annotated[
        Literal["gearbox", "bearing", "material", "preset"] | None,
        Argument("Entries of this kind alone."),
    ] = None,
    maker: Annotated[str, Argument("Part of the maker's name.")] = "",
    ratio: Annotated[
        Amount | None,
        Argument("Ratio for which the figures are valid.", Quantity("", "100", above=0)),
    ] = None,
    min_torque: Annotated[
        Amount | None,
        Argument("Least rated torque, '300 N m'.", Quantity("N m", "300 N m", above=0)),
    ] = None,
    max_lost_motion: Annotated[
        Amount | None,
        Argument(
            "Largest lost motion as printed, '1 arcmin'.", Quantity("rad", "1 arcmin", above=0)
        ),
    ] = None,
    min_stiffness: Annotated[
        Amount | None,
        Argument(
            "Least stiffness, of the softest zone, '50 N m/arcmin'.",
            Quantity("N m/rad", "50 N m/arcmin", above=0),
        ),
    ] = None,
    reducers: Annotated[
        "str | Path | Sequence[GearboxRow]",
        Argument(
            "TOML with [[reducers]] of your own, searched as well.",
            reducers_of,
            metavar="REDUCERS",
            aliases=("--file",),
        ),
    ] = (),
) -> Catalog:
    """Search the catalogue of reducers, bearings, materials and presets; every figure with its
    source and its confidence.

    Raises
    ------
    InputError
        With every mistake in the arguments and the file, for a name that is not in the catalogue,
        and for a maker without entries.

    """
    asked = read_arguments(catalog, locals())
    from lostmotion.analyses.catalog.page import catalogue_sheet
    from lostmotion.catalogue.search import Criteria

    wanted = Criteria(
        maker, asked.ratio, asked.min_torque, asked.max_lost_motion, asked.min_stiffness
    )
    return Catalog(catalogue_sheet(wanted, kind, name, asked.reducers))


@dataclass(frozen=True, repr=False)
class Catalog(Result):
    """Entries of the catalogue: `sheet.facts` has every row."""

    printed: Sheet

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed and written."""
        return self.printed
