"""Picture of an arm as SVG text: its bodies from the side, from the front and from above, without
any library for drawing.
"""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import LostmotionError, OutputExistsError
from lostmotion.mechanism.loops import joined_points
from lostmotion.mechanism.state import state_of
from lostmotion.reporting.arm_summary import about_arm
from lostmotion.reporting.palette import LIGHT, round_below

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.shape import Body
    from lostmotion.spatial import Floats

# Title of each view, with the directions of the base that point to the right, upwards, and towards
# the viewer.
_VIEWS: Final = {
    "from the side": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "from the front": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
    "from above": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
}
_AXES: Final = {"from the side": ("x", "z"), "from the front": ("y", "z"), "from above": ("x", "y")}
_PANEL: Final = 380
_GAP: Final = 24
# Head of the picture, with the titles of the views above their drawings.
_TOP: Final = 84
_BOTTOM: Final = 44
_FILL: Final = {
    "base": "line",
    "link": "c1",
    "offset": "line",
    "joint": "c2",
    "rail": "line",
    "tool": "warn",
    "payload": "design",
}
_MARK: Final = "lostmotion: picture of an arm"
_LABEL: Final = 12
# Radius of the ring about a closure.
_RING: Final = 5
# Mean width of a bold letter of this size, as wide as in common fonts.
_LETTER: Final = 7.3


def arm_picture(arm: Arm) -> str:
    """Return the arm at home, by default in the middle of its joint ranges, seen from three sides
    to one scale, as SVG text.

    Joints with a drive are named. A dashed outline marks a body whose size is chosen for the
    picture because no section states it; passive joints are hollow, and a ring marks a closure.
    """
    at = state_of(arm, arm.home[None]).frames[:, 0]
    corners = np.concatenate([body.corners_at(at[body.place]) for body in arm.bodies])
    low, high = corners.min(axis=0), corners.max(axis=0)
    scale = (_PANEL - 2 * _LABEL) / (float((high - low).max()) or 1.0)
    middle = (low + high) / 2
    width, height = 3 * _PANEL + 4 * _GAP, _TOP + _PANEL + _BOTTOM
    pose = "at home" if arm.closures else "every joint in the middle of its range"
    subtitle = f"{about_arm(arm)}; {pose}"
    font = f'font-family="system-ui, sans-serif" font-size="13" fill="{LIGHT["ink"]}"'
    parts = [
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'width="{width}" height="{height}" role="img" {font}>'
        ),
        f"<!-- {_MARK} -->",
        f"<title>{escape(arm.name)} from three sides</title>",
        f'<rect width="{width}" height="{height}" fill="{LIGHT["paper"]}"/>',
        f'<text x="{_GAP}" y="26" font-size="17" font-weight="600">{escape(arm.name)}</text>',
        f'<text x="{_GAP}" y="46" fill="{LIGHT["quiet"]}">{escape(subtitle)}</text>',
    ]
    for k, title in enumerate(_VIEWS):
        centre = (_GAP + k * (_PANEL + _GAP) + _PANEL / 2, _TOP + _PANEL / 2)
        parts += _view(arm, at, title, middle, scale, centre)
    dashed = any(_is_dashed(body) for body in arm.bodies)
    meanings = ["dashed: size chosen for the picture, no section is stated"] if dashed else []
    meanings += ["hollow: passive joint; ring: closure"] if arm.closures else []
    return "\n".join([*parts, *_scale_bar(scale, height, "; ".join(meanings)), "</svg>"]) + "\n"


def _is_dashed(body: Body) -> bool:
    """Return whether the size of a body is chosen for the picture."""
    return body.kind == "link" and not body.stated


def _view(
    arm: Arm, at: Floats, title: str, middle: Floats, scale: float, centre: tuple[float, float]
) -> list[str]:
    """Return one view: its bodies from far to near, and the names of the joints."""
    right, up, near = (np.array(axis, dtype=float) for axis in _VIEWS[title])
    flat = np.array([right, up])
    left, top = centre[0] - _PANEL / 2, centre[1] - _PANEL / 2

    def on_page(point: Floats) -> Floats:
        x, y = ((point - flat @ middle) * scale).T
        return np.column_stack([centre[0] + x, centre[1] - y])

    out = [
        (
            f'<rect x="{left:.1f}" y="{top:.1f}" width="{_PANEL}" height="{_PANEL}" '
            f'fill="{LIGHT["panel"]}"/>'
        ),
        (
            f'<text x="{left + 8:.1f}" y="{top - 8:.1f}" fill="{LIGHT["quiet"]}">{title}: '
            f"{_AXES[title][0]} →, {_AXES[title][1]} ↑</text>"
        ),
    ]
    hollow = {each.joint for each in arm.tree.passive}
    depth = {id(body): float(near @ (at[body.place] @ body.pose)[:3, 3]) for body in arm.bodies}
    for body in sorted(arm.bodies, key=lambda body: depth[id(body)]):
        points = " ".join(
            f"{x:.1f},{y:.1f}" for x, y in on_page(body.silhouette(at[body.place], flat))
        )
        dashed = ' stroke-dasharray="4 3"' if _is_dashed(body) else ""
        fill = "panel" if body.name in hollow else _FILL[body.kind]
        colours = f'fill="{LIGHT[fill]}" stroke="{LIGHT["ink"]}"'
        out.append(
            f'<polygon points="{points}" {colours} stroke-width="0.8" '
            f'stroke-linejoin="round"{dashed}/>'
        )
    for place, point in joined_points(arm.tree):
        ((x, y),) = on_page((flat @ (at[place] @ [*point, 1.0])[:3])[None])
        out.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{_RING}" fill="none" '
            f'stroke="{LIGHT["warn"]}" stroke-width="2"/>'
        )
    # left end, right end and height of the names before
    taken: list[tuple[float, float, float]] = []
    for joint, place in zip(arm.driven, arm.tree.moved, strict=True):
        ((x, y),) = on_page((flat @ at[place, :3, 3])[None])
        width = _LETTER * len(joint.name)
        x = max(min(x + 6, left + _PANEL - width - 4), left + 4)
        y = max(y, top + 2 * _LABEL)
        while any(
            x < end and start < x + width and abs(y - height) < _LABEL + 2
            for start, end, height in taken
        ):
            y += _LABEL + 2
        taken.append((x, x + width, y))
        out.append(
            f'<text x="{x:.1f}" y="{y - 4:.1f}" font-size="{_LABEL}" font-weight="600" '
            f'stroke="{LIGHT["panel"]}" stroke-width="3" '
            f'paint-order="stroke">{escape(joint.name)}</text>'
        )
    return out


def _scale_bar(scale: float, height: int, meaning: str) -> list[str]:
    """Return a bar of a round length, 1, 2 or 5 times a power of ten, at most a third of a view
    long.
    """
    size = round_below(_PANEL / 3 / scale)
    x, y = _GAP, height - 16
    text = f"{size:g} m" if size >= 1 else f"{1e3 * size:g} mm"
    return [
        f'<path d="M{x} {y}h{size * scale:.1f}" stroke="{LIGHT["ink"]}" stroke-width="3"/>',
        f'<text x="{x + size * scale + 8:.1f}" y="{y + 4}">{text}</text>',
        (
            f'<text x="{x + size * scale + 90:.1f}" y="{y + 4}" '
            f'fill="{LIGHT["quiet"]}">{meaning}</text>'
        ),
    ]


def write_picture(text: str, target: Path, *, force: bool = False) -> None:
    """Write a picture to a file. An earlier picture of an arm is replaced, any other file only with
    `force`.

    Raises OutputExistsError for another file, LostmotionError where nothing can be written.
    """
    try:
        if (
            target.exists()
            and not force
            and (not target.is_file() or _MARK.encode() not in target.read_bytes()[:1000])
        ):
            raise OutputExistsError(
                f"'{target}' exists and is not a picture of an arm\n  name another file with --out"
            )
        target.write_text(text, encoding="utf-8")
    except OSError as error:
        raise LostmotionError(
            f"'{target}' could not be written: {error.strerror or error}\n  name another file "
            "with --out"
        ) from error
