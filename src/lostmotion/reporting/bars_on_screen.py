"""Blocks of bars on the terminal, and the text around them."""

from __future__ import annotations

import math
import re
import textwrap
from typing import TYPE_CHECKING, Final

from rich.cells import cell_len
from rich.text import Text

if TYPE_CHECKING:
    from rich.console import Console

    from lostmotion.reporting.sheet import Bar, Bars

# Wider lines are not read more easily; narrower bars show nothing.
WIDEST: Final = 100
_SHORTEST_BAR: Final = 6
INDENT: Final = "  "
_EIGHTHS: Final = " ▏▎▍▌▋▊▉"
_BAR_STYLE: Final = "yellow"


def print_bars(screen: Console, block: Bars, width: int) -> None:
    """Print a block of bars: label, bar, figure, and the second figure where there is one."""
    labels = max(cell_len(bar.label) for bar in block.bars)
    figures = max(cell_len(str(bar.figure)) for bar in block.bars)
    effects = max(
        (cell_len(str(bar.effect)) for bar in block.bars if bar.effect is not None), default=0
    )
    room = width - len(INDENT) - labels - 2 - figures - 2 - (effects + 2 if effects else 0)
    plain = not (screen.encoding or "").lower().startswith("utf")
    column = f"{block.column}{f'; right: {block.effect}' if effects else ''}"
    heads = [f"{column}; {block.note}", column] if block.note else [column]
    head = next(
        (each for each in heads if width - cell_len(block.title) - cell_len(each) >= len(INDENT)),
        "",
    )
    if head:
        print_text(
            screen,
            Text.assemble(
                (block.title, "bold"),
                " " * (width - cell_len(block.title) - cell_len(head)),
                (head, "dim"),
            ),
        )
    else:
        print_text(screen, Text(block.title, style="bold"))
        print_text(screen, Text(column, style="dim"))
    for bar in block.bars:
        drawn = _drawn(bar, block, room, plain=plain) if room >= _SHORTEST_BAR else ""
        end = f"  {bar.figure!s:>{figures}}" + (
            f"  {'' if bar.effect is None else str(bar.effect):>{effects}}" if effects else ""
        )
        padded = bar.label + " " * (labels - cell_len(bar.label))
        print_text(screen, Text.assemble(f"{INDENT}{padded}  ", (drawn, _BAR_STYLE), end))
    if block.note and head != heads[0]:
        print_paragraph(screen, block.note, width, "dim")


def _drawn(bar: Bar, block: Bars, room: int, *, plain: bool) -> str:
    """Return one bar on the block's scale, in `room` columns; with a zero line where some bar is
    negative.
    """
    low, high = (
        min(0.0, *(each.size for each in block.bars)),
        max(0.0, block.most, *(each.size for each in block.bars)),
    )
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
    body = whole * (round(eighths / 8) if plain else eighths // 8) + (
        "" if plain else _EIGHTHS[eighths % 8].strip()
    )
    return (" " * zero + line + body).ljust(room)[:room]


def print_text(screen: Console, text: Text) -> None:
    """Print a text, folded at the width of the screen."""
    screen.print(text, soft_wrap=False)


def print_paragraph(screen: Console, text: str, width: int, style: str) -> None:
    """Print a paragraph, indented and folded at this width."""
    for line in wrapped(text, width - 2 * len(INDENT)):
        print_text(screen, Text(INDENT + line, style=style))


def wrapped(text: str, width: int) -> list[str]:
    """Return the lines of a text; a number stays with its unit, and a joint's name with its
    angle.
    """
    joined = re.sub(
        r"(?<=\d) (?=[%°µ]|[a-zA-Z]{1,3}\b)|(?<=\w) (?=-?\d+°)|(?<=\bN) (?=m\b)", "\u00a0", text
    )
    return [
        line.replace("\u00a0", " ")
        for line in textwrap.wrap(
            joined, max(width, 20), break_long_words=False, break_on_hyphens=False
        )
    ]
