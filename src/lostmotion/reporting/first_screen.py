"""The first screen of a result on the terminal: the answer, warnings, bars, and what the reader
asks next, on about 35 lines of 80 columns.
"""

from __future__ import annotations

import math
import re
import textwrap
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from rich.cells import cell_len
from rich.text import Text

from lostmotion.reporting.bars_on_screen import (
    INDENT,
    WIDEST,
    print_bars,
    print_paragraph,
    print_text,
    wrapped,
)
from lostmotion.reporting.screen import (
    console_of,
    legible_sheet,
    print_lines,
    print_section,
    print_sheet,
    width_of,
)
from lostmotion.reporting.sheet import several

if TYPE_CHECKING:
    from rich.console import Console

    from lostmotion.reporting.sheet import Card, Section, Sheet

_MOST_ROWS: Final = 15
# Figures that take no more lines below each other than in a row.
_MOST_STACKED: Final = 2


def print_first_screen(sheet: Sheet, console: Console | None = None) -> None:
    """Print the answer and the figures that are asked for first; a sheet without an answer is a
    table, and printed whole.
    """
    if not sheet.verdict:
        print_sheet(sheet, console)
        return
    screen = console_of(console)
    sheet = legible_sheet(sheet)
    width = min(screen.width, WIDEST)
    about = sheet.about or sheet.counts
    print_text(screen, Text.assemble((sheet.name, "bold"), f"   {about}" if about else ""))
    for warning in sheet.warnings:
        print_paragraph(screen, f"warning: {warning}", width, "bold red")
    print_paragraph(screen, sheet.verdict, width, "bold")
    stated = " ".join([sheet.verdict, *(text for _, text in sheet.brief)]) if sheet.bars else ""
    _print_cards(screen, tuple(card for card in sheet.cards if not _is_in(card, stated)), width)
    for block in sheet.bars:
        screen.print()
        print_bars(screen, block, width)
    if not sheet.bars:
        _print_main_table(screen, sheet)
    _print_brief(screen, sheet, width)
    print_lines(sheet, screen)


def _is_in(card: Card, text: str) -> bool:
    """Return whether a text has the number of a card, which says in words of what it is a bound."""
    return re.search(rf"{re.escape(card.number.lstrip('≥≤ '))}(?!\w)", text) is not None


def _print_brief(screen: Console, sheet: Sheet, width: int) -> None:
    """Print the statements below the bars, and with the last of them how many notes there are."""
    notes = f"{several(len(sheet.notes), 'note')} in the full output." if sheet.notes else ""
    if not sheet.brief and notes:
        print_text(screen, Text(notes, style="dim"))
    if not sheet.brief:
        return
    screen.print()
    indent = max(len(word) for word, _ in sheet.brief) + 2
    for number, (word, text) in enumerate(sheet.brief, 1):
        whole = f"{text} {notes}" if notes and number == len(sheet.brief) else text
        for k, line in enumerate(wrapped(whole, width - indent)):
            print_text(screen, Text.assemble((f"{word if k == 0 else '':{indent}}", "bold"), line))


def _print_cards(screen: Console, cards: tuple[Card, ...], width: int) -> None:
    """Print the figures that are asked for first: in a row where they fit, else as lines, each a
    number and what it is, as far as there is room.
    """
    if not cards:
        return
    screen.print()
    widths = [max(cell_len(card.title), cell_len(card.number)) + len(INDENT) for card in cards]
    if len(cards) > _MOST_STACKED and sum(widths) <= width:
        for texts in ([card.title for card in cards], [card.number for card in cards]):
            line = "".join(
                INDENT + text + " " * (taken - len(INDENT) - cell_len(text))
                for text, taken in zip(texts, widths, strict=True)
            )
            print_text(screen, Text(line.rstrip()))
        return
    numbers = max(cell_len(card.number) for card in cards)
    texts = [
        f"{INDENT}{' ' * (numbers - cell_len(card.number))}{card.number}  {card.title}"
        for card in cards
    ]
    titles = max(cell_len(text) for text in texts) + len(INDENT)
    for text, card in zip(texts, cards, strict=True):
        shorter = (card.quiet, card.quiet.partition(";")[0], "")
        quiet = next(each for each in shorter if not each or titles + cell_len(each) <= width)
        for folded in (
            textwrap.wrap(text, width, subsequent_indent=" " * (numbers + 4), drop_whitespace=True)
            if cell_len(text) > width
            else [text]
        ):
            print_text(
                screen,
                Text.assemble(
                    folded, (" " * (titles - cell_len(folded)) + quiet if quiet else "", "dim")
                ),
            )


def _print_main_table(screen: Console, sheet: Sheet) -> None:
    """Print the first table of a sheet, its first rows where it is long."""
    for section in sheet.sections[:1]:
        left = len(section.rows) - _MOST_ROWS
        shown = replace(section, rows=section.rows[:_MOST_ROWS], note="") if left > 0 else section
        screen.print()
        print_section(
            screen, shown if width_of(screen, shown) <= screen.width else _without_intervals(shown)
        )
        if left > 0:
            print_text(screen, Text(f"{INDENT}and {several(left, 'more row')}", style="dim"))


def _without_intervals(section: Section) -> Section:
    """Return a section whose figures have no interval: they stand in the full output where the
    screen is too narrow for them.
    """
    rows = tuple(
        replace(
            row,
            cells=tuple(replace(figure, low=math.nan, high=math.nan) for figure in row.cells),
        )
        for row in section.rows
    )
    return replace(section, rows=rows)
