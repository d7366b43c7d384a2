"""An arm with sized links, or with parts selected for a target, with its tables, plots and file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from lostmotion.analyses.result import Result
from lostmotion.analyses.sizing.sizing import Sizing
from lostmotion.analyses.sizing.target_study import PartSelection
from lostmotion.error_model.provenance import States, states

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet


class _Sized(Result):
    """Base of both results: `source` and `sidecar` are the files of the arm; None where it was
    given as an object.
    """

    source: Path | None
    sidecar: Path | None

    @property
    def _sizing(self) -> Sizing | PartSelection:
        return cast("Sizing | PartSelection", self)

    @property
    def _is_met(self) -> bool:
        return (
            self._sizing.meets_limits
            if isinstance(self._sizing, Sizing)
            else self._sizing.meets_target
        )

    @property
    def states(self) -> States:
        """Return what is known of each joint of the sized arm: stated, assumed, or ideal, and the
        assumed values.
        """
        return states(self._sizing.sized)

    @property
    def failure(self) -> str:
        """Return the verdict where limits or target are not met; empty where they are."""
        return "" if self._is_met else self.sheet.verdict

    def files(self) -> dict[str, bytes]:
        """Return the sized arm as sized.toml: its file with the new parts, where limits or target
        are met and the file is known.
        """
        from lostmotion.analyses.sizing.arm_writer import sized_text

        if self.source is None or not self._is_met:
            return {}
        return {"sized.toml": sized_text(self.source, self.sidecar, self._sizing).encode()}

    def further_files(self, folder: Path) -> Iterable[str]:
        """Return where the sized arm is, and what differs when it is read from there."""
        from lostmotion.analyses.sizing.arm_writer import reads_back

        if self.source is not None and self._is_met:
            doubt = reads_back(self.source, folder / "sized.toml", self._sizing)
            yield f"Sized arm: {folder / 'sized.toml'}" + (f"; {doubt}" if doubt else "")


@dataclass(frozen=True, repr=False)
class Size(Sizing, _Sized):
    """An arm with links sized by limits: `sized` is the arm; every attribute of `Sizing`."""

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
class Selection(PartSelection, _Sized):
    """An arm with parts selected for a target on the tool: `sized` is the arm; every attribute of
    `PartSelection`.
    """

    notes: tuple[str, ...] = ()
    source: Path | None = None
    sidecar: Path | None = None

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.sizing.tables.selection import selection_sheet

        return selection_sheet(self, self.notes)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.sizing.plots.selection import selection_plots

        return selection_plots(self)
