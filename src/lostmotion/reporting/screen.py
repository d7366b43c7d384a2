"""The summary on the terminal."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import TYPE_CHECKING, Final, TypeVar, cast

from rich import box
from rich.console import Console
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from lostmotion.errors import legible
from lostmotion.reporting.bars_on_screen import WIDEST, print_bars

if TYPE_CHECKING:
    from lostmotion.reporting.sheet import Section, Sheet

T = TypeVar("T")

# A remark in a narrower column than this is no longer read easily.
_REMARK: Final = 20
# Words in a cell that are longer than this are text.
_TEXT: Final = 24


def console_of(console: Console | None) -> Console:
    """Return the terminal to print on, standard output by default; in a notebook too, which would
    frame every line by itself.
    """
    return console or Console(force_jupyter=False)


def print_sheet(sheet: Sheet, console: Console | None = None) -> None:
    """Print every figure of a sheet, section by section, and last, where a terminal stands, the
    warnings and the answer in a sentence or three.
    """
    screen = console_of(console)
    sheet = legible_sheet(sheet)
    screen.print()
    screen.print(Text.assemble((sheet.name, "bold"), f"   {sheet.counts}" if sheet.counts else ""))
    for section in sheet.sections:
        screen.print()
        print_section(screen, section)
    _print_answer(sheet, screen)


def print_section(screen: Console, section: Section) -> None:
    """Print one table with its remarks, beside the figures where they have room, else below, and
    then its bars.
    """
    beside = any(row.note for row in section.rows) and _fits(screen, section)
    table = _table(section, remarks=beside)
    if _taken(screen, table) > screen.width:
        table = _table(section, remarks=beside, narrow=True)
    # Rather a line that the terminal folds than a figure cut to another one.
    screen.print(
        table, width=max(screen.width, screen.measure(table).minimum), crop=False, soft_wrap=False
    )
    if not beside:
        # a remark that many rows share is printed once
        for note in dict.fromkeys(row.note for row in section.rows if row.note):
            labels = "; ".join(row.label for row in section.rows if row.note == note)
            screen.print(Text.assemble((f"{labels}: ", "none"), (note, "dim")))
    if section.note:
        screen.print(Text(section.note, style="dim"))
    for block in section.bars:
        screen.print()
        print_bars(screen, block, min(screen.width, WIDEST))


def width_of(screen: Console, section: Section) -> int:
    """Return the columns that a section takes at least, its remarks below it."""
    return _taken(screen, _table(section, remarks=False, narrow=True))


def _print_answer(sheet: Sheet, screen: Console) -> None:
    """Print the notes, the statements of the first screen, the warnings, the answer, and lines to
    copy.
    """
    for note in sheet.notes:
        screen.print(Text(f"note: {note}", style="yellow"))
    for word, text in sheet.brief:
        screen.print(Text(f"{word}: {text}"))
    if sheet.verdict or sheet.warnings:
        screen.print()
    for warning in sheet.warnings:
        screen.print(Text(f"warning: {warning}", style="bold red"))
    if sheet.verdict:
        screen.print(Text(sheet.verdict, style="bold"))
    print_lines(sheet, screen)


def print_lines(sheet: Sheet, screen: Console) -> None:
    """Print the lines for the user's file, where there are some."""
    if sheet.lines:
        screen.print(Text(f"\n{sheet.lines.title}\n"))
        screen.print(Text(sheet.lines.text.rstrip()), soft_wrap=True)  # whole lines, to be copied


def legible_sheet(sheet: Sheet) -> Sheet:
    """Return a sheet with the control characters in its texts written out."""
    return _legible(sheet)


def _legible(held: T) -> T:
    """Write out control characters in all texts of a sheet: names come from files, and a terminal
    must obey none of them.
    """
    if isinstance(held, str):
        return cast("T", legible(held))
    if isinstance(held, tuple):
        return cast("T", tuple(_legible(each) for each in held))
    if is_dataclass(held) and not isinstance(held, type):
        return cast(
            "T",
            replace(
                held,
                **{
                    each.name: _legible(getattr(held, each.name))
                    for each in fields(held)
                    if each.name != "facts"
                },
            ),
        )
    return held


def _taken(screen: Console, table: Table) -> int:
    """Return the width of the table once drawn. Columns that cannot be narrower go beyond the
    screen, and further than `measure` says.
    """
    return max(Segment.get_line_length(line) for line in Segment.split_lines(screen.render(table)))


def _fits(screen: Console, section: Section) -> bool:
    """Return whether the rows' remarks have room at the right of the figures; otherwise they are
    printed below.
    """
    longest = max((len(row.note) for row in section.rows), default=0)
    taken = screen.measure(_table(section, remarks=False)).maximum
    return taken + min(longest, _REMARK) <= screen.width


def _table(section: Section, *, remarks: bool, narrow: bool = False) -> Table:
    # what "value" heads needs no heading
    plain = section.columns == ("value",) and not any(row.cells[0].interval for row in section.rows)
    table = Table(
        title=Text(section.title),
        title_justify="left",
        title_style="bold",
        box=box.SIMPLE_HEAD,
        show_header=not plain,
        pad_edge=False,
    )
    if narrow:
        table.show_edge, table.padding = False, (0, 1, 0, 0)
        # words in columns need no gaps between them
        if all(figure.words for row in section.rows for figure in row.cells):
            table.box = None
    table.add_column(
        "",
        min_width=max((len(word) for row in section.rows for word in row.label.split()), default=0),
    )
    with_interval = section.with_interval
    for k, (name, interval) in enumerate(zip(section.columns, with_interval, strict=True)):
        shown = [row.cells[k] for row in section.rows]
        texts = any(len(figure.words) > _TEXT for figure in shown)  # which folds; figures never do
        whole = [
            word for figure in shown for word in (figure.words.split() if texts else [str(figure)])
        ]
        table.add_column(
            name,
            justify="left" if texts else "right",
            min_width=max(map(len, [*whole, *name.split()]), default=0),
        )
        if interval:
            table.add_column("95 % interval", justify="left", no_wrap=True, style="dim")
    if remarks:
        table.add_column("", style="dim", overflow="fold")
    for row in section.rows:
        cells = []
        for figure, interval in zip(row.cells, with_interval, strict=True):
            cells.append(str(figure))
            if interval:
                cells.append(figure.interval)
        # as Text: brackets in them are no markup
        table.add_row(Text(row.label), *cells, *([Text(row.note)] if remarks else []))
    return table
