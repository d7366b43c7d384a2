"""Bars of the first screen as HTML tables: they reflow on a phone, and a screen reader reads a
table.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.reporting.page.text import escaped, foldable, spaced

if TYPE_CHECKING:
    from lostmotion.reporting.sheet import Bar, Bars


def bars(block: Bars) -> str:
    """Return a block of bars: title, what the colours mean, a line per bar, and a note."""
    return f"""<div class="bars">
<h2><a href="#{block.key}">{spaced(block.title)}</a></h2>
{_body(block)}</div>
"""


def bars_beside(block: Bars) -> str:
    """Return a block of bars that stands beside the table of its figures: one picture, since a
    screen reader reads that table.
    """
    figures = ", ".join(f"{bar.label} {bar.figure}" for bar in block.bars)
    words = (
        f"Bars. {block.title}; {block.column}: {figures}.{f' {block.note}.' if block.note else ''}"
    )
    return f"""<div class="bars" role="img" aria-label="{escaped(words)}">
<h3>{spaced(block.title)}</h3>
{_body(block)}</div>
"""


def _body(block: Bars) -> str:
    effect = f'<th scope="col" class="value">{spaced(block.effect)}</th>' if block.effect else ""
    lines = "".join(_line(bar, block) for bar in block.bars)
    note = f'<p class="quiet">{spaced(block.note)}</p>' if block.note else ""
    head = f'<td></td><th scope="col" colspan="2">{spaced(block.column)}</th>{effect}'
    return (
        f"{_stack(block)}<table><thead><tr>{head}</tr></thead><tbody>{lines}</tbody></table>\n"
        f"{note}"
    )


def _stack(block: Bars) -> str:
    named = "".join(
        f'<span><i class="s{k}"></i>{spaced(name)}</span>' for k, name in enumerate(block.stack)
    )
    return f'<p class="stack">{named}</p>' if named else ""


def _line(bar: Bar, block: Bars) -> str:
    effect = ""
    if block.effect:
        effect = (
            '<td class="value '
            f'effect">{spaced(str(bar.effect)) if bar.effect is not None else ""}</td>'
        )
    shown = spaced(str(bar.figure))
    return (
        f'<tr><th scope="row">{foldable(bar.label)}</th><td '
        f'class="bar">{_drawn(bar, block)}</td><td class="value">{shown}</td>{effect}</tr>'
    )


def _drawn(bar: Bar, block: Bars) -> str:
    """Return the pieces of a bar, positive ones from zero to the right, negative ones to the left;
    with a line at zero where there are such.
    """
    low, high = block.ends
    ends = {True: 0.0, False: 0.0}
    pieces = []
    for name, size in (
        ((f"s{k}", part) for k, part in enumerate(bar.parts))
        if bar.parts
        else (("whole", bar.size),)
    ):
        start = ends[size > 0]
        ends[size > 0] = start + size
        left, width = (
            100 * (min(start, start + size) - low) / (high - low),
            100 * abs(size) / (high - low),
        )
        if width >= 0.3:  # noqa: PLR2004 - thinner than a pixel
            pieces.append(f'<i class="{name}" style="left:{left:.1f}%;width:{width:.1f}%"></i>')
    zero = f'<b style="left:{-100 * low / (high - low):.1f}%"></b>' if low < 0 else ""
    return f"<span>{''.join(pieces)}{zero}</span>"
