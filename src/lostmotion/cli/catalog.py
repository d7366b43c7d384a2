"""`lostmotion catalog`: search the catalogue."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path  # noqa: TC003 - typer reads annotations
from typing import Annotated

import typer

from lostmotion.cli.app import amount, app
from lostmotion.cli.terminal import say_json
from lostmotion.version import __version__


class CatalogueKind(StrEnum):
    """What the catalogue holds."""

    gearbox = "gearbox"
    bearing = "bearing"
    material = "material"


@app.command()
def catalog(  # noqa: PLR0913, PLR0917 - options of a command line
    name: Annotated[str | None, typer.Argument(help="One entry whole: a reducer with or without its ratio, a material, a table of bearings.")] = None,
    kind: Annotated[CatalogueKind | None, typer.Option(help="Only these.")] = None,
    maker: Annotated[str, typer.Option(help="Part of the maker's name.")] = "",
    ratio: Annotated[str | None, typer.Option(help="A ratio of which the figures hold.")] = None,
    min_torque: Annotated[str | None, typer.Option(help="Least rated torque, '300 N m'.")] = None,
    max_lost_motion: Annotated[str | None, typer.Option(help="Most lost motion as printed, '1 arcmin'.")] = None,
    min_stiffness: Annotated[str | None, typer.Option(help="Least stiffness, of the softest zone, '50 N m/arcmin'.")] = None,
    file: Annotated[Path | None, typer.Option(help="TOML with [[reducers]] of your own, looked through as well.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print data for machines.")] = False,  # noqa: FBT002 - a switch
) -> None:
    """Search the catalogue of reducers, bearings and materials; every figure with its source and how sure it is."""
    from lostmotion.analyses.catalog.tables import catalogue_sheet
    from lostmotion.catalogue.search import Criteria
    from lostmotion.errors import Mistakes
    from lostmotion.io.own_reducers import read_reducers

    with Mistakes() as mistakes:
        wanted = Criteria(
            maker,
            mistakes.of(amount, "--ratio", ratio, "", "100"),
            mistakes.of(amount, "--min-torque", min_torque, "N m", "300 N m"),
            mistakes.of(amount, "--max-lost-motion", max_lost_motion, "rad", "1 arcmin"),
            mistakes.of(amount, "--min-stiffness", min_stiffness, "N m/rad", "50 N m/arcmin"),
        )
        own = mistakes.of(read_reducers, file) if file else ()
    sheet = catalogue_sheet(wanted, kind.value if kind else None, name, own)
    if as_json:
        say_json({"lostmotion": __version__, **sheet.facts})
    else:
        from lostmotion.reporting.screen import print_sheet

        print_sheet(sheet)
