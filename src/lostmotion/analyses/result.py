"""Result of a question: printed, written as a report, as plain data, and shown in a notebook."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any, ClassVar, Final

from lostmotion.errors import InputError, Problem, nearest, shown

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence
    from pathlib import Path
    from types import ModuleType

    import pandas as pd
    from matplotlib.figure import Figure

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.reporting.figure_files import FigureKind
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.reporting.table_files import TableKind


_MM_PER_INCH: Final = 25.4


class PartialResultError(InputError):
    """What was asked cannot be answered, but part of it can: `partial()` computes that result. The
    command line shows it in place of the message.
    """

    def __init__(self, problems: Sequence[Problem], partial: Callable[[], Result]) -> None:
        """Keep the mistakes and the function that computes what can be answered."""
        super().__init__(problems)
        self.partial = partial


class Result:
    """Base class of results: whatever has a sheet of figures can be printed, written and shown.

    page  the module beside the result's own that has its page: the functions `sheet` and, for a
          result with plots, `plots` of a result. It is loaded when the page is asked for.
    """

    page: ClassVar[str] = "page"

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        sheet: Sheet = self._page.sheet(self)
        return sheet

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        plots: Sequence[Plot] = getattr(self._page, "plots", lambda _: ())(self)
        return plots

    @property
    def _page(self) -> ModuleType:
        return importlib.import_module(f"{type(self).__module__.rpartition('.')[0]}.{self.page}")

    @property
    def failure(self) -> str:
        """Return why the answer is no, in a sentence; empty where it is yes. The command line then
        exits with 1.
        """
        return ""

    def files(self) -> dict[str, bytes]:
        """Return what the report's folder holds besides report.html and result.json, by name."""
        return {}

    def outcome(self, written: Path) -> str:
        """Return the line that names what was written; empty where nothing was."""
        return f"Report: {written / 'report.html'}"

    def further_files(self, folder: Path) -> Iterable[str]:  # noqa: ARG002 - for results with further files
        """Return a line for each file that the command line names besides the report."""
        return ()

    def summary(self, *, full: bool = False) -> None:
        """Print the answer and the figures that are asked for first, on one screen; every figure
        with `full`.
        """
        from lostmotion.reporting.first_screen import print_first_screen
        from lostmotion.reporting.screen import print_sheet

        (print_sheet if full else print_first_screen)(self.sheet)

    def figure(self, key: str = "", *, size: tuple[float, float] | None = None) -> Figure:
        """Return a plot of the report as a matplotlib figure, which `savefig` writes as SVG, PDF or
        PNG.

        key   name of the plot, by default the first; `[plot.key for plot in result.plots]` lists
              them
        size  width and height, mm; by default that of the report

        No setting of matplotlib is changed. Raises InputError for a key that the result has no plot
        of.
        """
        plots = self.plots
        keys = [plot.key for plot in plots]
        if key not in {*keys, ""} or not keys:
            near = nearest(key, keys)
            expected = (
                "one of " + ", ".join(keys) if keys else "a result with plots; this one has none"
            )
            raise InputError(
                [
                    Problem(
                        "",
                        "key",
                        shown(key),
                        expected,
                        nearest=near,
                        passing=(("key", near or next(iter(keys), "")),),
                    )
                ]
            )
        made = plots[keys.index(key) if key else 0].figure
        if size is not None:
            made.set_size_inches(size[0] / _MM_PER_INCH, size[1] / _MM_PER_INCH)
        return made

    def report(
        self,
        out: str | Path,
        *,
        force: bool = False,
        figures: FigureKind | None = None,
        tables: TableKind | None = None,
    ) -> Path:
        """Write report.html, result.json and the files besides into the folder `out`, whole or not
        at all, and return the folder.

        figures  "svg", "pdf" or "png": also every plot as a file in the folder figures
        tables   "csv" or "latex": also every table as a file in the folder tables

        Missing parents are made. With `force` an earlier folder is replaced once the new one is
        complete. The same result gives the same bytes. Raises OutputExistsError where the folder
        exists and `force` is not set, LostmotionError where it cannot be written.
        """
        from lostmotion.reporting.folder import refuse_existing, write_whole
        from lostmotion.reporting.page.document import contents

        refuse_existing(out, force=force)
        plots = self.plots
        return write_whole(
            {**contents(self.sheet, plots), **self.files(), **self.copies(plots, figures, tables)},
            out,
            force=force,
        )

    def copies(
        self, plots: Sequence[Plot], figures: FigureKind | None, tables: TableKind | None
    ) -> dict[str, bytes]:
        """Return its plots and tables as the contents of files of these kinds, by name in the
        report's folder.
        """
        from lostmotion.reporting.figure_files import figure_files
        from lostmotion.reporting.table_files import table_files

        drawn = {} if figures is None else figure_files(plots, figures)
        return {**drawn, **({} if tables is None else table_files(self.sheet, tables))}

    def result(self) -> dict[str, Any]:
        """Return every printed figure as plain data, as in result.json."""
        from lostmotion.reporting.layout import plain
        from lostmotion.version import __version__

        return plain(self.sheet, __version__)

    @property
    def figures(self) -> Mapping[str, Estimate]:
        """Return every figure in SI with its interval, by its keys in result.json: "section.row",
        or "section.row.column".
        """
        from lostmotion.reporting.layout import estimates_by_key

        return {key: found for key, _, found in estimates_by_key(self.sheet.sections)}

    def frame(self) -> pd.DataFrame:
        """Return the same as a table: one row for each key, with name, value, ends of the 95 %
        interval, SI unit, and whether it is a lower or an upper bound.
        """
        from lostmotion.reporting.layout import estimates_by_key

        return frame_of(
            (key, name, found, "") for key, name, found in estimates_by_key(self.sheet.sections)
        )

    def __repr__(self) -> str:
        """Return the figures that are asked for first, one a line."""
        sheet = self.sheet
        head = f"<{type(self).__name__} of '{sheet.name}'" + (
            f": {sheet.counts}" if sheet.counts else ""
        )
        return "\n".join([head, *(f"  {card.title}: {card.number}" for card in sheet.cards)]) + ">"

    def _first_plot(self) -> Plot | None:
        """Return the plot that a notebook shows beside the figures; None where none stands for the
        whole.
        """
        return None

    def _repr_mimebundle_(self, include: object = None, exclude: object = None) -> dict[str, str]:  # noqa: ARG002 - as IPython calls it
        """Show the answer in a notebook: one line of text, and HTML with picture, figures, bars and
        tables.
        """
        from lostmotion.reporting.page.notebook import notebook_bundle

        return notebook_bundle(self.sheet, self._first_plot())

    def _repr_html_(self) -> str:
        """Show the same on hosts that ask for HTML alone."""
        return self._repr_mimebundle_()["text/html"]


def frame_of(figures: Iterable[tuple[str, str, Estimate, str]]) -> pd.DataFrame:
    """Return figures, each a key, a name, an estimate and a definition, as a table by key."""
    import pandas as pd

    rows = [
        (key, name, found.value, found.low, found.high, found.unit, found.bound, definition)
        for key, name, found, definition in figures
    ]
    columns = ["key", "name", "value", "low", "high", "unit", "bound", "definition"]
    return pd.DataFrame(rows, columns=columns).set_index("key")
