"""The settings of matplotlib with which all charts are drawn, whatever the user's are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from lostmotion.reporting.palette import LIGHT

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

# Sizes of letters, pt.
SMALL: Final = 8.5
_TEXT: Final = 9.5
_STYLE: Final[dict[Any, Any]] = {
    "font.family": "sans-serif",
    "font.size": _TEXT,
    "text.color": LIGHT["ink"],
    "text.parse_math": False,
    "axes.edgecolor": LIGHT["quiet"],
    "axes.linewidth": 0.8,
    "axes.labelcolor": LIGHT["quiet"],
    "axes.titlesize": _TEXT,
    "axes.titlecolor": LIGHT["ink"],
    "axes.titlelocation": "left",
    "axes.titlepad": 8.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.facecolor": "none",
    "axes.unicode_minus": True,
    "figure.facecolor": LIGHT["paper"],
    "legend.frameon": False,
    "legend.fontsize": SMALL,
    "svg.fonttype": "none",
    "svg.hashsalt": "lostmotion",
}
# Groups of settings that change what is drawn; the others belong to windows and the machine.
_DRAWING: Final = {
    "axes",
    "contour",
    "errorbar",
    "font",
    "grid",
    "legend",
    "lines",
    "patch",
    "path",
    "pdf",
    "polaraxes",
    "savefig",
    "svg",
    "text",
} | {f"{axis}{what}" for axis in "xy" for what in ("axis", "tick")}


def settings() -> AbstractContextManager[None]:
    """Return a context with matplotlib's own settings and those of all charts, whatever the user's
    are; they are back afterwards.
    """
    import matplotlib as mpl

    own: dict[Any, Any] = {
        key: value
        for key, value in mpl.rcParamsDefault.items()
        if key.partition(".")[0] in _DRAWING
    }
    return mpl.rc_context({**own, **_STYLE})
