"""An arm whose links were sized, or whose parts were chosen for a target, with its tables, plots and file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from lostmotion.analyses.result import Result
from lostmotion.analyses.sizing.sizing import Sizing
from lostmotion.analyses.sizing.target_study import Aimed
from lostmotion.error_model.provenance import States, states

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet


class _Sized(Result):
    """What both have: the sized arm and the file that it was read from, `source` with its `sidecar`; None where it was given as an object."""

    source: Path | None
    sidecar: Path | None

    @property
    def _found(self) -> Sizing | Aimed:
        return cast("Sizing | Aimed", self)

    @property
    def states(self) -> States:
        """Return what is known of each joint of the sized arm: stated, assumed, or ideal, and the assumed values."""
        return states(self._found.sized)

    @property
    def failure(self) -> str:
        """Return which limit, or that the target, is not met, where one is not."""
        return "" if self._found.holds else self.sheet.verdict

    def files(self) -> dict[str, bytes]:
        """Return the sized arm as sized.toml: the text of its file with the chosen parts, where limits or target are met and the file is known."""
        from lostmotion.analyses.sizing.arm_writer import sized_text

        if self.source is None or not self._found.holds:
            return {}
        return {"sized.toml": sized_text(self.source, self.sidecar, self._found).encode()}

    def written_besides(self, folder: Path) -> Iterable[str]:
        """Return where the sized arm is, and what differs when it is read from there."""
        from lostmotion.analyses.sizing.arm_writer import reads_back

        if self.source is not None and self._found.holds:
            doubt = reads_back(self.source, folder / "sized.toml", self._found)
            yield f"Sized arm: {folder / 'sized.toml'}" + (f"; {doubt}" if doubt else "")


@dataclass(frozen=True, repr=False)
class Size(Sizing, _Sized):
    """An arm whose links were sized by limits: `sized` is the arm; every attribute of `Sizing`."""

    source: Path | None = None
    sidecar: Path | None = None

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.sizing.tables.sizing import sizing_sheet

        return sizing_sheet(self)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.sizing.plots.sizing import sizing_plots

        return sizing_plots(self)


@dataclass(frozen=True, repr=False)
class Selection(Aimed, _Sized):
    """An arm whose parts were chosen for a target on the tool: `sized` is the arm; every attribute of `Aimed`."""

    notes: tuple[str, ...] = ()
    source: Path | None = None
    sidecar: Path | None = None

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.sizing.tables.selection import aimed_sheet

        return aimed_sheet(self, self.notes)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.sizing.plots.selection import aimed_plots

        return aimed_plots(self)
