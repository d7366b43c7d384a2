"""What was asked for, to be looked at: on the screen, as a report, as plain data, in a notebook."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lostmotion.errors import refuse_argument
from lostmotion.studies.answer import Answer

if TYPE_CHECKING:
    from pathlib import Path

    import xarray

    from lostmotion.arm import Arm
    from lostmotion.figures import Sheet
    from lostmotion.studies.analytic import Analytic, Pooled
    from lostmotion.studies.gear import GearStudy
    from lostmotion.studies.poses import Poses
    from lostmotion.studies.sizing import Sizing


class Shown(ABC):
    """Whatever has a sheet of figures can be printed, given as plain data, and shown in a notebook."""

    @property
    @abstractmethod
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""

    def summary(self) -> None:
        """Print every figure."""
        from lostmotion.screen import print_sheet

        print_sheet(self.sheet)

    def result(self) -> dict[str, Any]:
        """Give every printed figure as plain data, as in result.json."""
        from lostmotion import __version__
        from lostmotion.figures import plain

        return plain(self.sheet, __version__)

    def _repr_html_(self) -> str:
        """Show the figures as tables in a notebook."""
        from lostmotion.report.page import tables

        return tables(self.sheet)


class Study(Answer, Shown):
    """A study that can be looked at: `summary()`, `report("out/")`, `arrays()`, `result()`; every attribute of `Answer` besides."""

    @property
    def sheet(self) -> Sheet:
        """Give what an engineer asks for: workspace, error, AP and RP, budget, torques, each with its interval and sample."""
        from lostmotion.figures.arm import sheet

        return sheet(self)

    def report(self, out: str | Path, *, force: bool = False) -> Path:
        """Write report.html, result.json and arrays.nc into the folder `out`, whole or not at all; gives the folder.

        Raises OutputExistsError where the folder exists and `force` is not set.
        """
        from lostmotion.report.arm import write_folder

        return write_folder(self, out, force=force)

    def arrays(self) -> xarray.Dataset:
        """Give every result per pose and per robot with its name, unit and coordinates."""
        from lostmotion.arrays import dataset

        return dataset(self)

    def __repr__(self) -> str:
        """Tell the result in a few lines."""
        from lostmotion.figures.arm import sections

        wanted = {"error": 4, "iso9283": 4, "budget": 3}
        lines = [
            f"<Study of '{self.arm.name}': {len(self.poses)} poses x {self.sampled.robots} robots x {self.sampled.visits} visits, seed {self.seed}"
        ]
        for section in sections(self):
            for row in section.rows[: wanted.get(section.key, 0)]:
                interval = f"  ({row.figures[0].interval})" if row.figures[0].interval else ""
                share = f", {row.figures[1]} of the mean square" if section.key == "budget" else ""
                lines.append(f"  {row.label:32} {row.figures[0]}{interval}{share}")
        return "\n".join(lines) + ">"


@dataclass(frozen=True)
class Gear(Shown):
    """One gearbox that was looked at: `summary()`, `report("out/")`, `result()`, `drawing()`; `study` holds every number."""

    name: str
    notes: tuple[str, ...]
    study: GearStudy

    @property
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""
        from lostmotion.figures.gearbox import gearbox_sheet

        return gearbox_sheet(self.name, self.study, self.notes)

    def report(self, out: str | Path, *, force: bool = False) -> Path:
        """Write report.html, result.json and, for a cycloidal gearbox with ezdxf installed, profile.dxf into the folder `out`, whole or not at all.

        Gives the folder. Raises OutputExistsError where it exists and `force` is not set.
        """
        from lostmotion.formats.dxf import can_draw
        from lostmotion.report.gearbox import write_gearbox

        drawing = self.drawing() if self.study.drawn is not None and can_draw() else None
        return write_gearbox(self.sheet, self.study, drawing, out, force=force)

    def drawing(self) -> bytes:
        """Give the profiles as a DXF drawing; raises InputError for a gearbox by stated figures, LostmotionError where ezdxf is not installed."""
        from lostmotion.formats.dxf import profile_dxf
        from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox

        gearbox = self.study.gearbox
        if not isinstance(gearbox, CycloidalGearbox):
            raise refuse_argument("dxf", f"a gearbox of kind '{gearbox.kind}'", "one by its drawing, of kind 'cycloidal'")
        return profile_dxf(gearbox, self.name)


@dataclass(frozen=True)
class Size(Shown):
    """An arm whose links were sized: `summary()`, `report("out/")`, `result()`; `found.sized` is the arm, `found` holds every number."""

    found: Sizing

    @property
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""
        from lostmotion.figures.sizing import sizing_sheet

        return sizing_sheet(self.found)

    def report(self, out: str | Path, source: str | Path | None = None, sidecar: str | Path | None = None, *, force: bool = False) -> Path:
        """Write report.html and result.json into the folder `out`, whole or not at all; with the arm's `source`, where limits hold, sized.toml too.

        `source` is the file that the arm was read from, with its `sidecar` where it is a URDF whose sidecar does not lie beside it. Gives the folder.
        Raises OutputExistsError where it exists and `force` is not set.
        """
        from lostmotion.formats.sized import sized_text
        from lostmotion.report.sizing import write_sizing

        text = sized_text(source, sidecar, self.found) if source is not None and self.found.holds else None
        return write_sizing(self.sheet, self.found, text, out, force=force)


@dataclass(frozen=True, repr=False)
class AnalyticStudy(Shown):
    """A study without sampling: `analytic` holds every pose, `pooled` all of them; `summary()`, `report("out/")`, `result()`."""

    arm: Arm
    poses: Poses
    analytic: Analytic
    pooled: Pooled

    @property
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""
        from lostmotion.figures.analytic import analytic_sheet

        return analytic_sheet(self.arm, self.poses, self.analytic, self.pooled)

    def report(self, out: str | Path, *, force: bool = False) -> Path:
        """Write report.html and result.json into the folder `out`, whole or not at all; gives the folder.

        Raises OutputExistsError where the folder exists and `force` is not set.
        """
        from lostmotion.report.folder import write_whole
        from lostmotion.report.page import contents

        return write_whole(contents(self.sheet, ()), out, force=force)

    def __repr__(self) -> str:
        """Tell in a line what was studied."""
        return f"<AnalyticStudy of '{self.arm.name}': {len(self.poses)} poses; mean {self.pooled.mean.value:.4g} m>"
