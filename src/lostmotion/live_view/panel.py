"""Texts and bars of the panel, as HTML with styles of its own; the marks in `id` are for tests."""

from __future__ import annotations

import html
import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import legible
from lostmotion.live_view.picture import COLOURS
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.printed import digits, factor_of, unit_of_length
from lostmotion.reporting.palette import DARK
from lostmotion.reporting.provenance import missing_clause
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.budget import Cost
    from lostmotion.error_model.provenance import States
    from lostmotion.live_view.picture import Classes
    from lostmotion.live_view.session import ErrorOverWorkspace, Figures
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_PARTS_SHOWN: Final = 8
_AMBER, _BLUE, _RED = DARK["design"], DARK["robot"], DARK["warn"]
_QUIET: Final = "font-size:12px;opacity:.75"
_ROW: Final = "display:grid;gap:.5em;align-items:center;font-size:12px;line-height:1.65"
# Width of the names beside bars, in the width of a letter m: per letter, and at most.
_PER_LETTER, _WIDEST_NAME = 0.58, 14.0


def headline(
    figures: Figures,
    over_all: ErrorOverWorkspace | None,
    factor: float | None,
    known: States | None = None,
) -> str:
    """Return the error at the pose and over the workspace, as a bound where kinds of error are
    missing, which are named.

    factor  how much larger the picture shows the error, None where it is not known yet
    known   states of the kinds of error of the arm; None: what is missing is not shown
    """
    about = "" if figures.is_precise else "about "
    least = "" if known is None or not known.lower_bound else "at least "
    missing = "" if known is None else missing_clause(known)
    named = (
        f'<div id="lm-missing" style="{_QUIET}">{html.escape(legible(missing))}</div>'
        if missing
        else ""
    )
    whole = "…" if over_all is None else f"{least}{_size(over_all.whole.value)}"
    size = (
        ""
        if factor is None
        else f"{factor:,.0f} × larger"
        if factor >= 1
        else f"at {factor:g} of their size"
    )
    drawn = "…" if factor is None else f"arrow: mean error, ellipsoid: 95 % of errors; both {size}"
    return _block(
        f'<div style="{_QUIET}">95 % of positions at this pose within</div>'
        '<div id="lm-q95" '
        f'style="font-size:28px;font-weight:650;line-height:1.15">{least}{about}{_size(figures.q95)}</div>'
        f"{named}"
        f'<div style="{_QUIET}">mean {least}{_size(float(figures.error.mean[0]))}; over the '
        f'workspace <b id="lm-all">{whole}</b></div>'
        f'<div style="{_QUIET}">{drawn}</div>'
    )


def budget_bars(costs: Sequence[Cost]) -> str:
    """Return bars of the parts that contribute most to the mean-square error at the pose; a part
    that cancels others extends to the left.
    """
    shown = costs[:_PARTS_SHOWN]
    rows = [(short_name(cost.part), cost.share, f"{digits(100 * cost.share)} %") for cost in shown]
    rest = sum(cost.share for cost in costs[_PARTS_SHOWN:])
    others = (
        f'<div style="{_QUIET}">{len(costs) - _PARTS_SHOWN} others: {digits(100 * rest)} %</div>'
        if len(costs) > _PARTS_SHOWN
        else ""
    )
    return _block(_title("Which part is to blame here") + _bars(rows, _AMBER) + others)


def torque_bars(arm: Arm, figures: Figures) -> str:
    """Return bars of the torque or force that each drive holds.

    They are shares of the rated torque, red above it. Drives without a rating have no bar; where
    none has one, bars compare the torques.
    """
    rated = np.isfinite(figures.loads).any()
    sizes = np.nan_to_num(figures.loads if rated else np.abs(figures.torques)).tolist()
    rows = []
    for joint, size, torque, load in zip(
        arm.driven, sizes, figures.torques.tolist(), figures.loads.tolist(), strict=True
    ):
        share = f", {100 * load:.0f} %" if math.isfinite(load) else ""
        rows.append((joint.name, size, f"{digits(abs(torque))} {joint.load_unit}{share}"))
    title = (
        "Holding load of the drives, share of rated"
        if rated
        else "Holding load of the drives (no rating stated)"
    )
    return _block(_title(title) + _bars(rows, _BLUE, full=1.0 if rated else None))


def legend(classes: Classes, *, lower_bound: bool = False) -> str:
    """Return the colour classes with their limits, each between the classes that it separates;
    whether the errors are lower bounds.
    """
    unit = unit_of_length(classes.limits[-1])
    factor = factor_of(unit)
    limits = [f"{limit * factor:.10g}" for limit in classes.limits]
    cells = "".join(
        f'<span style="flex:1"><i style="display:block;height:9px;background:{colour}"></i>'
        "<span "
        f'style="display:block;text-align:center;transform:translateX(50%)">{text}</span></span>'
        for colour, text in zip(COLOURS, [*limits, ""], strict=True)
    )
    title = (
        f'<div style="{_QUIET}">points: 95 % of positions there within{" at least" * lower_bound}, '
        f"{unit}</div>"
    )
    return _block(
        f'{title}<div style="display:flex;font-size:11px;padding:.2em 0 .4em">{cells}</div>'
    )


def status(count: int, milliseconds: float) -> str:
    """Return how long the newest figures took; `count` counts the updates."""
    return _block(
        f'<div id="lm-n" data-n="{count}" style="font-size:11px;opacity:.6">computed in '
        f"{milliseconds:.0f} ms</div>"
    )


def warning(text: str) -> str:
    """Return a warning, as several lines where it has them."""
    lines = "<br>".join(html.escape(legible(line)) for line in text.splitlines())
    return (
        _block(f'<div id="lm-warning" style="font-size:12px;color:{_RED}">{lines}</div>')
        if text
        else ""
    )


def pose_option(arm: Arm, q: Floats) -> str:
    """Return the option `--at` for a pose q (joint,), rad and m; read again it is the same pose to
    1e-9 rad or m.
    """
    values = (
        f"{joint.name}={math.degrees(value):.9g}deg"
        if joint.type == "revolute"
        else f"{joint.name}={value * 1e3:.9g}mm"
        for joint, value in zip(arm.driven, q.tolist(), strict=True)
    )
    return f'--at "{" ".join(values)}"'


def text_to_copy(text: str) -> str:
    """Return a line to copy."""
    style = "font-family:monospace;font-size:11px;user-select:all;overflow-wrap:anywhere"
    return _block(f'<div id="lm-at" style="{style}">{html.escape(legible(text))}</div>')


def _size(value: float) -> str:
    return str(length(value))


def _block(content: str) -> str:
    return f'<div style="padding:0 .9em">{content}</div>'


def _title(text: str) -> str:
    return f'<div style="font-weight:600;font-size:13px;margin:.5em 0 .1em">{text}</div>'


def _bars(rows: Sequence[tuple[str, float, str]], colour: str, full: float | None = None) -> str:
    """Return a row with label, bar and text for each size; the longest bar, or `full`, takes the
    whole width, and longer ones are red.
    """
    low = min(0.0, *(size for _, size, _ in rows)) if rows else 0.0
    high = full if full is not None else max((size for _, size, _ in rows), default=0.0)
    span = (high - low) or 1.0
    wide = min(max((_PER_LETTER * len(label) for label, _, _ in rows), default=0.0), _WIDEST_NAME)
    texts = max((_PER_LETTER * len(text) for *_, text in rows), default=0.0)
    grid = f"{_ROW};grid-template-columns:{wide:.1f}em 1fr {texts:.1f}em"
    out = []
    for label, size, text in rows:
        start, end = (
            100 * (each - low) / span for each in (min(size, 0.0), min(max(size, 0.0), high))
        )
        paint = _RED if full is not None and size > full else colour
        bar = f"margin-left:{start:.1f}%;width:{end - start:.1f}%;height:10px;border-radius:2px;background:{paint}"  # noqa: E501
        name = html.escape(legible(label))
        out.append(
            f'<div style="{grid}"><span title="{name}" '
            f'style="overflow:hidden;text-overflow:ellipsis;white-space:nowrap">{name}</span>'
            f'<span><i style="display:block;{bar}"></i></span><span '
            f'style="text-align:right;font-variant-numeric:tabular-nums">{text}</span></div>'
        )
    return "".join(out)
