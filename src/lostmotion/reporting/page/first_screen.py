"""The first screen of a page: whose figures these are, the answer in a sentence, what it rests on,
and the figures that are asked for first.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.reporting.page.bars import bars
from lostmotion.reporting.page.text import NARROW, escaped, folded, headline, spaced
from lostmotion.reporting.page.viewer import viewer
from lostmotion.reporting.svg import inline_svg

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Card, Sheet


def first_screen(sheet: Sheet, drawn: Sequence[Plot], version: str) -> str:
    """Return the header of a page; `drawn` are the plots that stand beside the key figures and the
    first block of bars.
    """
    answer, rest = headline(sheet.verdict) if sheet.verdict else (escaped(sheet.name), "")
    about = (sheet.about, sheet.subject, sheet.counts, f"lostmotion {version}")
    identity = "".join(f"<span>{spaced(each)}</span>" for each in about if each)
    lead = f'<p class="lead">{rest}</p>\n' if rest else ""
    warnings = "".join(
        f'<p class="warn" role="alert"><strong>Warning:</strong> {spaced(warning)}</p>\n'
        for warning in sheet.warnings
    )
    notes = (
        f'<ul class="notes">{"".join(f"<li>{spaced(note)}</li>" for note in sheet.notes)}</ul>\n'
        if sheet.notes
        else ""
    )
    lines = (
        f"<p>{escaped(sheet.lines.title)}</p><pre>{escaped(sheet.lines.text)}</pre>\n"
        if sheet.lines
        else ""
    )
    cards = f'<dl class="numbers">{"".join(map(_card, sheet.cards))}</dl>\n' if sheet.cards else ""
    scenes = "".join(viewer(plot.scene) for plot in drawn if plot.scene is not None)
    pictures = scenes + "".join(
        (
            f'<figure id="plot-{plot.key}">{inline_svg(plot)}<figcaption '
            f'aria-hidden="true">{spaced(plot.words)}</figcaption></figure>'
        )
        for plot in drawn
    )
    if pictures:
        cards = (
            f'<div class="first"><div>{pictures}</div>\n'
            f"<div>{cards}{''.join(map(bars, sheet.bars[:1]))}</div></div>\n"
        )
    below = sheet.bars[1:] if pictures else sheet.bars
    statements = "".join(
        f"<dt>{spaced(word)}</dt><dd>{spaced(sentence)}</dd>" for word, sentence in sheet.brief
    )
    brief = f'<dl class="words">{statements}</dl>' if statements else ""
    blocks = (
        f'<div class="blocks">{"".join(map(bars, below))}{brief}</div>\n' if below or brief else ""
    )
    return f"""<header>
<p class="identity"><b>{escaped(sheet.name)}</b>{identity}</p>
<h1>{answer}</h1>
{lead}{warnings}{lines}{cards}{blocks}{notes}</header>"""


def _card(card: Card) -> str:
    quiet = f'<dd class="quiet">{folded(spaced(card.quiet))}</dd>' if card.quiet else ""
    # rather a second line than a cut unit
    shown = spaced(card.number).replace(NARROW, f"{NARROW}<wbr>").replace("/arcmin", "/<wbr>arcmin")
    return f'<div><dt>{spaced(card.title)}</dt><dd class="number">{shown}</dd>{quiet}</div>'
