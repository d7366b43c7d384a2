"""One gearbox: play, stiffness, lost motion, transmission error, with its tables, plots and
drawing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from lostmotion.analyses.gearbox.gear import GearStudy
from lostmotion.analyses.result import Result
from lostmotion.errors import refuse_argument

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from lostmotion.analyses.gearbox.finite_elements import FiniteElements
    from lostmotion.laws.cycloid.finite_elements.wheel import Field
    from lostmotion.reporting.figure_files import FigureKind
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.reporting.table_files import TableKind


@dataclass(frozen=True, repr=False)
class Gear(GearStudy, Result):
    """One gearbox: every attribute of `GearStudy`; `dxf` is an additional file for the profiles,
    `fem` its stages by finite elements.
    """

    name: str = "gearbox"
    notes: tuple[str, ...] = ()
    dxf: Path | None = None
    fem: tuple[FiniteElements, ...] = ()

    @property
    def sheet(self) -> Sheet:
        """Return the sheet with every figure."""
        from lostmotion.analyses.gearbox.tables.gearbox import gearbox_sheet

        sheet = gearbox_sheet(self.name, self, self.notes, self.fem)
        return (
            replace(sheet, drawing="the profiles of disc and ring in mm") if self._drawn else sheet
        )

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.gearbox.plots.finite_elements import fem_plots
        from lostmotion.analyses.gearbox.plots.gearbox import gearbox_plots

        return [*gearbox_plots(self), *fem_plots(self.fem)]

    @property
    def _drawn(self) -> bool:
        from lostmotion.io.dxf import can_draw

        return self.drawn is not None and can_draw()

    def _fields(self) -> Iterable[tuple[str, Field]]:
        """Yield the fields of the meshed wheels by file name; a rigid ring has none."""
        for found in self.fem:
            first = "first-stage-" if found.name == "first stage" else ""
            yield from zip((f"{first}planet.vtu", f"{first}ring.vtu"), found.fields, strict=False)

    def files(self) -> dict[str, bytes]:
        """Return the profile of a cycloidal gearbox as profile.dxf where ezdxf is installed, and
        the fields of the finite elements as VTU files.
        """
        from lostmotion.io.vtu import vtu

        out = {"profile.dxf": self.drawing()} if self._drawn else {}
        for name, each in self._fields():
            fields = {
                "displacement_m": each.displacement,
                "von_mises_Pa": each.von_mises,
                "equivalent_strain": each.strain,
            }
            out[name] = vtu(each.points, each.triangles, fields)
        return out

    def report(
        self,
        out: str | Path,
        *,
        force: bool = False,
        figures: FigureKind | None = None,
        tables: TableKind | None = None,
    ) -> Path:
        """Write report.html, result.json and, for a cycloidal gearbox with ezdxf installed,
        profile.dxf into the folder `out`.

        Errors as `Result.report`, and OutputExistsError where the file `dxf` exists and `force` is
        not set.
        """
        from lostmotion.analyses.gearbox.drawing import refuse_existing_file, write_drawing

        if self.dxf is None:
            return super().report(out, force=force, figures=figures, tables=tables)
        refuse_existing_file(self.dxf, force=force)
        drawing = self.drawing()
        written = super().report(out, force=force, figures=figures, tables=tables)
        write_drawing(drawing, self.dxf, force=force)
        return written

    def further_files(self, folder: Path) -> Iterable[str]:
        """Return where the drawing is, or why there is none."""
        from lostmotion.io.dxf import CHORD_ERROR

        if self._drawn:
            yield (
                f"Drawing: {self.dxf or folder / 'profile.dxf'} (mm, chords within "
                f"{CHORD_ERROR * 1e6:g} µm of the profile)"
            )
        elif self.drawn is not None:
            yield "Drawing: none, ezdxf is not installed: pip install 'lostmotion[dxf]'"
        for name, _ in self._fields():
            yield f"Finite elements: {folder / name} (for ParaView; lengths in m, stresses in Pa)"

    def drawing(self) -> bytes:
        """Return the profiles as a DXF drawing; raises InputError for a gearbox by stated figures,
        LostmotionError where ezdxf is not installed.
        """
        from lostmotion.io.dxf import profile_dxf

        refuse_drawing(self.gearbox)
        return profile_dxf(self.gearbox, self.name)  # type: ignore[arg-type]


def refuse_drawing(gearbox: object) -> None:
    """Raise InputError for a gearbox that has no drawing."""
    from lostmotion.parts.gearbox.kinds import is_drawn

    if not is_drawn(gearbox):
        found = f"a gearbox of kind '{getattr(gearbox, 'kind', type(gearbox).__name__)}'"
        raise refuse_argument(
            "dxf", found, "a gearbox with a drawing, of kind 'cycloidal', or no DXF file"
        )
