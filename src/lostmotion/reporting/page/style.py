"""Style of a page: colours of both schemes as CSS variables, then the rules."""

from __future__ import annotations

from importlib.resources import files
from typing import Final

from lostmotion.reporting.palette import CLASSES, css_variables

_FONT: Final = (
    'system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue","Liberation Sans",Arial,sans-serif'
)
# Colours of a drawn arm; amber for small text, which the amber of bars is too light for.
_OF_ARM: Final = (
    {"tube": "#c9d1d9", "joint": "#3c4650", "base": "#8d97a1", "amber": "#8f5600"},
    {"tube": "#aab4be", "joint": "#e7ecf1", "base": "#5b6670", "amber": "#f0a93c"},
)


def style() -> str:
    """Return the style sheet. Paper is white: print takes the light colours whatever the reader's
    scheme is.
    """
    light, dark = (
        css_variables(dark=k > 0) + "".join(f"--{name}:{colour};" for name, colour in arm.items())
        for k, arm in enumerate(_OF_ARM)
    )
    classes = "".join(
        f".c{k}{{fill:var(--c{k})}}.k{k}{{background:var(--c{k})}}" for k in range(len(CLASSES))
    )
    rules = files(__package__).joinpath("style.css").read_text(encoding="utf-8")
    return (
        f":root{{color-scheme:light dark;--font:{_FONT};{light}}}\n@media screen and "
        f"(prefers-color-scheme:dark){{:root{{{dark}}}}}\n"
        f"{classes}\n{rules}"
    )
