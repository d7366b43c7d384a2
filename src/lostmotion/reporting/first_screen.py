"""The first screen of a result on the terminal: the answer, warnings, bars, and what the reader asks next, on about 35 lines of 80 columns."""

from __future__ import annotations

import math
import re
import textwrap
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from rich.cells import cell_len
from rich.text import Text

from lostmotion.reporting.screen import console_of, legible_sheet, print_lines, print_section, print_sheet, width_of
from lostmotion.reporting.sheet import several

if TYPE_CHECKING:
    from rich.console import Console

    from lostmotion.reporting.sheet import Bar, Bars, Card, Section, Sheet

# Wider lines are not read more easily; narrower bars show nothing.
_WIDEST: Final = 100
_SHORTEST_BAR: Final = 6
_MOST_ROWS: Final = 15
# Figures that take no more lines below each other than in a row.
_MOST_STACKED: Final = 2
_INDENT: Final = "  "
_EIGHTHS: Final = " ▏▎▍▌▋▊▉"
_BAR_STYLE: Final = "yellow"


def print_first_screen(sheet: Sheet, console: Console | None = None) -> None:
    """Print the answer and the figures that are asked for first; a sheet without an answer is a table, and printed whole."""
    if not sheet.verdict:
        print_sheet(sheet, console)
        return
    screen = console_of(console)
    sheet = legible_sheet(sheet)
    width = min(screen.width, _WIDEST)
    about = sheet.about or sheet.counts
    _print(screen, Text.assemble((sheet.name, "bold"), f"   {about}" if about else ""))
    for warning in sheet.warnings:
        _print_paragraph(screen, f"warning: {warning}", width, "bold red")
    _print_paragraph(screen, sheet.verdict, width, "bold")
    stated = " ".join([sheet.verdict, *(text for _, text in sheet.brief)]) if sheet.bars else ""
    _print_cards(screen, tuple(card for card in sheet.cards if not _is_in(card, stated)), width)
    for block in sheet.bars:
        screen.print()
        _print_bars(screen, block, width)
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
        _print(screen, Text(notes, style="dim"))
    if not sheet.brief:
        return
    screen.print()
    indent = max(len(word) for word, _ in sheet.brief) + 2
    for number, (word, text) in enumerate(sheet.brief, 1):
        whole = f"{text} {notes}" if notes and number == len(sheet.brief) else text
        for k, line in enumerate(_wrapped(whole, width - indent)):
            _print(screen, Text.assemble((f"{word if k == 0 else '':{indent}}", "bold"), line))


def _print(screen: Console, text: Text) -> None:
    screen.print(text, soft_wrap=False)


def _print_paragraph(screen: Console, text: str, width: int, style: str) -> None:
    for line in _wrapped(text, width - 2 * len(_INDENT)):
        _print(screen, Text(_INDENT + line, style=style))


def _wrapped(text: str, width: int) -> list[str]:
    """Return the lines of a text; a number stays with its unit, and a joint's name with its angle."""
    joined = re.sub(r"(?<=\d) (?=[%°µ]|[a-zA-Z]{1,3}\b)|(?<=\w) (?=-?\d+°)|(?<=\bN) (?=m\b)", "\u00a0", text)
    return [line.replace("\u00a0", " ") for line in textwrap.wrap(joined, max(width, 20), break_long_words=False, break_on_hyphens=False)]


def _print_cards(screen: Console, cards: tuple[Card, ...], width: int) -> None:
    """Print the figures that are asked for first: in a row where they fit, else as lines, each a number and what it is, as far as there is room."""
    if not cards:
        return
    screen.print()
    widths = [max(cell_len(card.title), cell_len(card.number)) + len(_INDENT) for card in cards]
    if len(cards) > _MOST_STACKED and sum(widths) <= width:
        for texts in ([card.title for card in cards], [card.number for card in cards]):
            line = "".join(_INDENT + text + " " * (taken - len(_INDENT) - cell_len(text)) for text, taken in zip(texts, widths, strict=True))
            _print(screen, Text(line.rstrip()))
        return
    numbers = max(cell_len(card.number) for card in cards)
    texts = [f"{_INDENT}{' ' * (numbers - cell_len(card.number))}{card.number}  {card.title}" for card in cards]
    titles = max(cell_len(text) for text in texts) + len(_INDENT)
    for text, card in zip(texts, cards, strict=True):
        shorter = (card.quiet, card.quiet.partition(";")[0], "")
        quiet = next(each for each in shorter if not each or titles + cell_len(each) <= width)
        for folded in textwrap.wrap(text, width, subsequent_indent=" " * (numbers + 4), drop_whitespace=True) if cell_len(text) > width else [text]:
            _print(screen, Text.assemble(folded, (" " * (titles - cell_len(folded)) + quiet if quiet else "", "dim")))


def _print_bars(screen: Console, block: Bars, width: int) -> None:
    """Print a block of bars: label, bar, figure, and the second figure where there is one."""
    labels = max(cell_len(bar.label) for bar in block.bars)
    figures = max(cell_len(str(bar.figure)) for bar in block.bars)
    effects = max((cell_len(str(bar.effect)) for bar in block.bars if bar.effect is not None), default=0)
    room = width - len(_INDENT) - labels - 2 - figures - 2 - (effects + 2 if effects else 0)
    plain = not (screen.encoding or "").lower().startswith("utf")
    column = f"{block.column}{f'; right: {block.effect}' if effects else ''}"
    heads = [f"{column}; {block.note}", column] if block.note else [column]
    head = next((each for each in heads if width - cell_len(block.title) - cell_len(each) >= len(_INDENT)), "")
    if head:
        _print(screen, Text.assemble((block.title, "bold"), " " * (width - cell_len(block.title) - cell_len(head)), (head, "dim")))
    else:
        _print(screen, Text(block.title, style="bold"))
        _print(screen, Text(column, style="dim"))
    for bar in block.bars:
        drawn = _drawn(bar, block, room, plain=plain) if room >= _SHORTEST_BAR else ""
        end = f"  {bar.figure!s:>{figures}}" + (f"  {'' if bar.effect is None else str(bar.effect):>{effects}}" if effects else "")
        padded = bar.label + " " * (labels - cell_len(bar.label))
        _print(screen, Text.assemble(f"{_INDENT}{padded}  ", (drawn, _BAR_STYLE), end))
    if block.note and head != heads[0]:
        _print_paragraph(screen, block.note, width, "dim")


def _drawn(bar: Bar, block: Bars, room: int, *, plain: bool) -> str:
    """Return one bar on the block's scale, in `room` columns; with a zero line where some bar is negative."""
    low, high = min(0.0, *(each.size for each in block.bars)), max(0.0, *(each.size for each in block.bars))
    if not high > low:
        return " " * room
    zero = math.ceil(-low / (high - low) * (room - 1)) if low < 0 else 0
    per_column = (room - zero - (1 if low < 0 else 0)) / high if high > 0 else 0.0
    line = "" if not low < 0 else "|" if plain else "│"
    whole = "#" if plain else "█"
    if bar.size < 0:
        left = min(zero, max(1, round(zero * bar.size / low)))
        return (" " * (zero - left) + whole * left + line).ljust(room)
    eighths = round(8 * bar.size * per_column)
    body = whole * (round(eighths / 8) if plain else eighths // 8) + ("" if plain else _EIGHTHS[eighths % 8].strip())
    return (" " * zero + line + body).ljust(room)[:room]


def _print_main_table(screen: Console, sheet: Sheet) -> None:
    """Print the first table of a sheet, its first rows where it is long."""
    for section in sheet.sections[:1]:
        left = len(section.rows) - _MOST_ROWS
        shown = replace(section, rows=section.rows[:_MOST_ROWS], note="") if left > 0 else section
        screen.print()
        print_section(screen, shown if width_of(screen, shown) <= screen.width else _without_intervals(shown))
        if left > 0:
            _print(screen, Text(f"{_INDENT}and {left} more rows", style="dim"))


def _without_intervals(section: Section) -> Section:
    """Return a section whose figures have no interval: they stand in the full output where the screen is too narrow for them."""
    rows = tuple(replace(row, figures=tuple(replace(figure, low=math.nan, high=math.nan) for figure in row.figures)) for row in section.rows)
    return replace(section, rows=rows)
