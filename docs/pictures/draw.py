"""Draw the pictures of the tour as SVG files: `python docs/pictures/draw.py` writes them beside
this file.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    Point = tuple[float, float]

FOLDER: Final = Path(__file__).parent
INK, GREY, BLUE, RED, STEEL, PALE = "#1b1f24", "#6b7280", "#1f5fbf", "#c2410c", "#cfd6df", "#eef1f5"


def line(
    *points: Point, colour: str = INK, width: float = 2, dashes: str = "", fill: str = "none"
) -> str:
    """Return a line through the points; with a fill, the area inside it."""
    joined = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    tag = "polyline" if fill == "none" else "polygon"
    dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
    return (
        f'<{tag} points="{joined}" fill="{fill}" stroke="{colour}" stroke-width="{width}"{dashed} '
        'stroke-linejoin="round" stroke-linecap="round"/>'
    )


def circle(
    x: float, y: float, r: float, *, colour: str = INK, fill: str = "#ffffff", width: float = 2
) -> str:
    """Return a circle about (x, y)."""
    return (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r:.1f}" fill="{fill}" stroke="{colour}" '
        f'stroke-width="{width}"/>'
    )


def box(
    x: float, y: float, width: float, height: float, *, fill: str = STEEL, colour: str = INK
) -> str:
    """Return a rectangle with its upper left corner at (x, y)."""
    return (
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" fill="{fill}" '
        f'stroke="{colour}" stroke-width="2"/>'
    )


def text(
    x: float,
    y: float,
    words: str,
    *,
    colour: str = INK,
    anchor: str = "middle",
    size: int = 14,
    code: bool = False,
) -> str:
    """Return words at (x, y); `code` for names of keys."""
    family = "monospace" if code else "sans-serif"
    escaped = words.replace("&", "&amp;").replace("<", "&lt;")
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" font-family="{family}" font-size="{size}" '
        f'text-anchor="{anchor}">{escaped}</text>'
    )


def key(x: float, y: float, words: str, *, anchor: str = "middle") -> str:
    """Return the name of a key or table of the arm file."""
    return text(x, y, words, colour=BLUE, anchor=anchor, code=True)


def arrow(
    start: Point, end: Point, *, colour: str = INK, both: bool = False, width: float = 2
) -> str:
    """Return an arrow; `both` for a dimension line with a head at each end."""
    angle = math.atan2(end[1] - start[1], end[0] - start[0])
    heads = [(end, angle)] + ([(start, angle + math.pi)] if both else [])
    out = line(start, end, colour=colour, width=width)
    for (x, y), way in heads:
        sides = [
            (x - 9 * math.cos(way + turn), y - 9 * math.sin(way + turn)) for turn in (0.4, -0.4)
        ]
        out += line((x, y), *sides, colour=colour, width=1, fill=colour)
    return out


def frame(x: float, y: float, turn: float = 0, size: float = 34) -> str:
    """Return the axes x and z of a frame, x turned up from the right by an angle in degrees."""
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    out = arrow((x, y), (x + size * c, y - size * s), colour=RED) + arrow(
        (x, y), (x - size * s, y - size * c), colour=RED
    )
    out += text(x + (size + 10) * c, y - (size + 10) * s + 4, "x", colour=RED, size=12)
    return out + text(x - (size + 10) * s, y - (size + 10) * c + 4, "z", colour=RED, size=12)


def ground(x: float, y: float, width: float) -> str:
    """Return level ground with its hatching."""
    hatches = (
        line((at, y + 10), (at + 10, y), colour=GREY, width=1)
        for at in range(int(x), int(x + width) - 9, 10)
    )
    return line((x, y), (x + width, y)) + "".join(hatches)


def curve(points: Iterable[Point], origin: Point, scale: Point, **style: str | float) -> str:
    """Return a curve given in its own units about an origin on the page."""
    return line(*((origin[0] + scale[0] * x, origin[1] - scale[1] * y) for x, y in points), **style)  # type: ignore[arg-type]


def axes(
    origin: Point, left: float, right: float, down: float, up: float, names: tuple[str, str]
) -> str:
    """Return two axes through an origin with the names of what they count."""
    x, y = origin
    across = arrow((x - left, y), (x + right, y), colour=GREY, width=1) + text(
        x + right, y + 18, names[0], colour=GREY, size=12, anchor="end"
    )
    return (
        across
        + arrow((x, y + down), (x, y - up), colour=GREY, width=1)
        + text(x + 6, y - up + 4, names[1], colour=GREY, size=12, anchor="start")
    )


def chain() -> str:
    """Draw an arm with the table of the file that describes each of its pieces."""
    out = ground(20, 260, 170) + box(60, 215, 90, 45, fill=PALE) + key(105, 243, "[base]")
    joints = [(105, 195), (230, 90), (420, 110)]
    for start, end in ((joints[0], joints[1]), (joints[1], joints[2]), (joints[2], (520, 180))):
        out += line(start, end, colour=GREY, width=16) + line(start, end, colour=STEEL, width=12)
    for x, y in joints:
        out += circle(x, y, 17, fill=PALE) + circle(x, y, 4, fill=INK)
    out += (
        line((520, 180), (545, 198), width=6)
        + frame(552, 203, -35)
        + circle(590, 255, 20, fill="#fde7c7")
        + line((556, 208), (578, 240), colour=GREY)
    )
    out += (
        key(325, 130, "link")
        + key(230, 52, "[[joints]]")
        + key(450, 60, "gearbox, bearing, encoder")
    )
    return (
        out
        + key(545, 158, "[tool]", anchor="start")
        + key(560, 285, "[payload]")
        + text(150, 140, "link", colour=BLUE, code=True, anchor="end")
    )


def base() -> str:
    """Draw where the arm stands, how its base leans, and the springs that carry it."""
    out = (
        ground(20, 225, 180)
        + line((45, 180), (165, 210), width=14, colour=STEEL)
        + line((45, 225), (165, 225), colour=GREY, width=1, dashes="4 4")
    )
    out += frame(105, 192, -14) + text(
        120, 255, 'pitch = "1 deg ± 0.2 deg"', colour=BLUE, code=True, size=12
    )
    out += (
        ground(240, 225, 160)
        + box(290, 150, 60, 75, fill=PALE)
        + circle(320, 140, 10)
        + frame(262, 218)
        + arrow((262, 218), (318, 142), colour=BLUE)
    )
    out += (
        text(320, 255, "xyz, rpy: base to arm", colour=BLUE, size=12)
        + ground(440, 225, 170)
        + box(470, 150, 110, 22)
    )
    for x in (490, 560):
        out += line(*((x + (6 if i % 2 else -6), 172 + i * 53 / 8) for i in range(9)))
    return (
        out
        + key(525, 140, "linear_stiffness")
        + key(525, 120, "angular_stiffness")
        + text(525, 255, "or compliance, or tracks", colour=BLUE, size=12)
    )


def joint() -> str:
    """Draw a joint's seat, its axis and its link up to the next seat."""
    out = (
        line((10, 236), (60, 200), colour=STEEL, width=12)
        + frame(60, 200)
        + text(90, 246, "link before", size=12)
        + arrow((66, 196), (178, 152), colour=BLUE)
    )
    out += (
        key(100, 150, "origin")
        + circle(185, 150, 16, fill=PALE)
        + circle(185, 150, 4, fill=INK)
        + text(185, 190, "seat and axis")
    )
    out += (
        line((185, 150), (430, 60), colour=GREY, width=16)
        + line((185, 150), (430, 60), colour=STEEL, width=12)
        + circle(185, 150, 16, fill=PALE)
    )
    out += (
        frame(185, 150, 0, 60)
        + arrow((185, 150), (300, 108), colour=BLUE, width=3)
        + text(310, 130, "direction", colour=BLUE, code=True, anchor="start")
    )
    out += arrow((172, 122), (418, 32), both=True, colour=BLUE, width=1) + text(
        285, 62, "length", colour=BLUE, code=True, anchor="end"
    )
    out += (
        circle(430, 60, 5, fill=INK)
        + text(445, 95, "tip: the next seat", anchor="start")
        + frame(430, 60, 0, 40)
    )
    return out + text(
        340,
        270,
        "direction = [0.94, 0, 0.34]: where the link leads, in the joint's axes (x unless stated)",
        size=12,
    )


def sections() -> str:
    """Draw the kinds of sections, and those that change along a link."""
    out = (
        circle(60, 70, 38, fill=STEEL)
        + circle(60, 70, 28)
        + circle(160, 70, 38, fill=STEEL)
        + box(225, 35, 70, 70)
        + box(237, 47, 46, 46, fill="#ffffff")
    )
    out += box(335, 35, 50, 70) + line(*_beam_outline(430, 35), fill=STEEL)
    out += line((520, 105), (520, 35), (590, 35), (590, 50), (537, 50), (537, 105), fill=STEEL)
    for x, name in (
        (60, "tube"),
        (160, "rod"),
        (260, "box"),
        (360, "rectangle"),
        (460, "I"),
        (555, "outline"),
    ):
        out += key(x, 132, name)
    out += (
        box(30, 165, 90, 40)
        + box(120, 173, 60, 24)
        + line((220, 165), (380, 175), (380, 195), (220, 205), fill=STEEL)
    )
    out += box(420, 165, 160, 40, fill="#8b95a3") + box(420, 173, 160, 24)
    return out + key(105, 232, "stepped") + key(300, 232, "tapered") + key(500, 232, "composite")


def _beam_outline(x: float, y: float) -> list[Point]:
    steps = [
        (0, 0),
        (60, 0),
        (60, 12),
        (36, 12),
        (36, 58),
        (60, 58),
        (60, 70),
        (0, 70),
        (0, 58),
        (24, 58),
        (24, 12),
        (0, 12),
    ]
    return [(x + dx, y + dy) for dx, dy in steps]


def gearbox() -> str:
    """Draw the torque-angle loop of a gearbox, and its transmission error over a turn."""
    origin = (190.0, 140.0)
    falling = [
        (130.0, 94.0),
        (35.0, 62.0),
        (0.0, 36.0),
        (0.0, -8.0),
        (-35.0, -38.0),
        (-130.0, -94.0),
    ]
    rising = [(-x, -y) for x, y in falling]
    out = axes(origin, 165, 170, 125, 120, ("torque", "angle of the output"))
    out += curve(falling, origin, (1, 1), width=3) + curve(rising, origin, (1, 1), width=3)
    out += arrow((182, 118), (182, 162), both=True, colour=RED) + text(
        174, 144, "backlash", colour=RED, anchor="end", size=13
    )
    out += arrow((200, 104), (200, 176), both=True, colour=BLUE) + text(
        208, 172, "+ hysteresis: the loop", colour=BLUE, anchor="start", size=12
    )
    out += (
        text(222, 74, "K1", anchor="end", colour=BLUE)
        + text(270, 56, "K2", colour=BLUE, anchor="end")
        + text(280, 240, "slope: 1 / stiffness", size=12, colour=BLUE)
    )
    out += axes((420, 140), 10, 220, 60, 80, ("", "error of the output")) + text(
        640, 200, "angle of the input", colour=GREY, size=12, anchor="end"
    )
    wave = [(x, 26 * math.sin(x / 18) + 8 * math.sin(x / 5)) for x in range(200)]
    out += (
        curve(wave, (425, 140), (1, 1), colour=BLUE)
        + arrow((632, 106), (632, 174), both=True, width=1)
        + text(650, 98, "peak to peak", anchor="end", size=12)
    )
    return out + key(530, 235, "transmission_error")


def bearing() -> str:
    """Draw a spaced pair of bearings whose clearance lets the axis tilt."""
    out = line((60, 175), (470, 95), colour=STEEL, width=26) + line(
        (40, 135), (490, 135), colour=GREY, width=1, dashes="8 4"
    )
    for x in (150, 370):
        out += box(x - 16, 70, 32, 34, fill=PALE) + box(x - 16, 172, 32, 34, fill=PALE)
        out += circle(x, 112, 8, fill=STEEL) + circle(x, 163, 8, fill=STEEL)
    out += (
        arrow((150, 228), (370, 228), both=True, width=1, colour=BLUE)
        + key(260, 248, "span")
        + line((490, 135), (490, 92), colour=RED)
    )
    out += text(498, 78, "tilt = clearance / span", anchor="start", colour=RED, size=12)
    return out + key(150, 55, "clearance") + text(370, 55, "free play of each bearing", size=12)


def encoder() -> str:
    """Draw the two places of an encoder: before the gearbox and behind it."""
    out = ""
    for y, side, at in ((70, "motor", 70), (190, "output", 430)):
        out += (
            box(110, y - 25, 80, 50, fill=PALE)
            + text(150, y + 5, "motor")
            + line((190, y), (250, y), width=6)
            + box(250, y - 35, 120, 70)
        )
        out += (
            text(310, y + 5, "gearbox")
            + line((370, y), (560, y), width=6)
            + circle(575, y, 14, fill=PALE)
            + text(600, y + 5, "joint", anchor="start")
        )
        out += (
            line((110, y), (70, y), width=4)
            + box(at - 14, y - 26, 28, 52, fill="#bfd6f6")
            + key(at, y - 36, f'side = "{side}"', anchor="start" if side == "motor" else "middle")
        )
    out += text(330, 130, "backlash and wind-up are not measured", size=12, colour=RED)
    return out + text(
        330, 250, "backlash and wind-up lie inside the control loop", size=12, colour=RED
    )


def mounting() -> str:
    """Draw an axis that is tilted and offset, and a whole joint's lumped error."""
    out = box(60, 150, 200, 50, fill=STEEL) + line(
        (160, 215), (160, 30), colour=GREY, dashes="8 4", width=1
    )
    out += (
        line((178, 210), (202, 30), colour=RED, width=3)
        + arrow((160, 175), (182, 175), colour=BLUE, width=1)
        + key(175, 240, "offset")
    )
    out += text(215, 50, "tilt", colour=BLUE, code=True, anchor="start") + text(
        110, 50, "as drawn", colour=GREY, size=12
    )
    out += (
        circle(400, 150, 22, fill=PALE)
        + line((400, 150), (570, 150), colour=STEEL, width=12)
        + line((400, 150), (566, 105), colour=RED, dashes="6 4")
    )
    out += line((400, 150), (566, 195), colour=RED, dashes="6 4") + circle(
        400, 150, 8, fill="none", colour=RED
    )
    return (
        out + text(590, 155, "±", colour=RED, size=18) + key(500, 225, "lumped = { angle, offset }")
    )


def payload() -> str:
    """Draw the tool's frame, the payload's centre of mass and a process force."""
    out = (
        line((30, 120), (190, 120), colour=STEEL, width=22)
        + text(110, 95, "last link")
        + line((190, 120), (290, 120), width=8)
        + frame(300, 120, 0, 50)
    )
    out += (
        arrow((194, 140), (296, 140), both=True, colour=BLUE, width=1)
        + key(245, 162, "frame")
        + circle(420, 165, 26, fill="#fde7c7")
    )
    out += (
        circle(420, 165, 3, fill=INK)
        + arrow((303, 122), (416, 163), colour=BLUE)
        + key(440, 210, "centre_of_mass")
        + text(458, 160, "mass", anchor="start", colour=BLUE, code=True)
    )
    return (
        out
        + arrow((300, 120), (300, 215), colour=RED, width=4)
        + key(300, 237, "force")
        + text(300, 40, "[tool]", colour=BLUE, code=True)
        + key(440, 120, "[payload]")
    )


def tolerance() -> str:
    """Draw the distributions that a tolerance may have."""
    out = ""
    normal = [(x / 20, math.exp(-((x / 20) ** 2) * 4.5)) for x in range(-20, 21)]
    tails = [(x / 20, math.exp(-((x / 20) ** 2) * 4.5)) for x in range(-28, 29)]
    table = [(-1, 0), (-1, 0.17), (0.2, 0.17), (0.2, 0.62), (1, 0.62), (1, 0)]
    kinds = (
        ("± 50 µm", normal),
        ("(uniform)", [(-1, 0), (-1, 0.5), (1, 0.5), (1, 0)]),
        ("(normal without limits)", tails),
        ("law = [[-1, 0], …]", table),
    )
    for index, (name, points) in enumerate(kinds):
        x = 90 + 155 * index
        out += line((x - 70, 160), (x + 70, 160), colour=GREY, width=1) + curve(
            points, (x, 160), (45, 100), colour=BLUE, width=3
        )
        out += (
            line((x - 45, 165), (x - 45, 150), colour=RED)
            + line((x + 45, 165), (x + 45, 150), colour=RED)
            + text(x, 205, name, size=11, colour=BLUE, code=True)
        )
    return out + text(
        320,
        235,
        "red: the stated limits, at three standard deviations of a normal distribution",
        size=12,
        colour=RED,
    )


def zone() -> str:
    """Draw a zone in the workspace, by its limits along the base's axes."""
    out = (
        ground(60, 235, 520)
        + (
            '<path d="M 140 225 A 190 190 0 0 1 510 225 Z" fill="#eef1f5" stroke="#6b7280" '
            'stroke-width="2"/>'
        )
        + frame(325, 225, 0, 40)
    )
    out += (
        box(390, 110, 80, 70, fill="#bfd6f6", colour=BLUE)
        + text(430, 150, "zone")
        + line((390, 180), (390, 250), colour=BLUE, dashes="4 4")
    )
    out += line((470, 180), (470, 250), colour=BLUE, dashes="4 4") + text(
        430, 262, "x 0.2..0.5 m", colour=BLUE, code=True, size=12
    )
    return (
        out
        + text(230, 150, "workspace", colour=GREY)
        + text(485, 150, "z 0.3..0.6 m", colour=BLUE, code=True, anchor="start", size=12)
    )


def sidecar() -> str:
    """Draw what of an arm comes from its URDF and what from the TOML beside it."""
    out = (
        box(30, 60, 170, 120, fill=PALE)
        + text(115, 85, "arm.urdf", code=True)
        + box(250, 60, 170, 120, fill="#dbe8fa")
        + text(335, 85, "arm.toml", code=True)
    )
    for row, (left, right) in enumerate(
        (
            ("kinematics", "gearboxes, bearings"),
            ("limits", "encoders, sections"),
            ("masses", "tip, base, payload"),
        )
    ):
        out += text(115, 113 + 22 * row, left, size=12) + text(335, 113 + 22 * row, right, size=12)
    out += (
        text(225, 125, "+", size=22)
        + arrow((430, 120), (490, 120))
        + box(500, 60, 110, 120)
        + text(555, 115, "arm")
        + text(555, 138, "with errors", size=12)
    )
    return out + text(
        320,
        220,
        "joined by the names of the joints: [joints.shoulder_pan_joint]",
        colour=BLUE,
        size=12,
    )


def _pin(x: float, y: float, *, drive: bool = False) -> str:
    """Return a hinge: filled where it has a drive."""
    return circle(x, y, 13, fill=STEEL if drive else "#ffffff")


def closure() -> str:
    """Draw a loop of two branches that a closure joins, and a leg between base and platform."""
    left, right, elbows, tip = (70, 215), (190, 215), ((35, 130), (225, 130)), (130, 60)
    out = ground(20, 232, 230)
    for start, end in ((left, elbows[0]), (right, elbows[1]), (elbows[0], tip), (elbows[1], tip)):
        out += line(start, end, width=10, colour=STEEL)
    out += _pin(*left, drive=True) + _pin(*right, drive=True) + "".join(_pin(*at) for at in elbows)
    out += _pin(*tip) + circle(*tip, 19, fill="none", colour=RED)
    out += (
        key(130, 28, "[[closures]] joins")
        + key(58, 112, "passive", anchor="start")
        + text(58, 150, "start", colour=BLUE, code=True, anchor="start")
        + key(130, 260, 'after = "base"')
        + text(130, 190, "drive", size=12)
    )
    foot, top = (400, 215), (470, 75)
    out += ground(360, 232, 250) + box(410, 52, 170, 18, fill=PALE)
    out += text(495, 40, 'platform: type = "free"', colour=BLUE, code=True, size=13)
    out += line(foot, (428, 159), width=16, colour=STEEL) + line((428, 159), top, width=8)
    out += _pin(*foot) + _pin(*top) + circle(*top, 19, fill="none", colour=RED)
    out += box(414, 133, 28, 30, fill=STEEL)
    for x, y, name in (
        (498, 90, "spherical, cone: end"),
        (456, 152, "prismatic: a drive"),
        (424, 205, "universal, axes: place"),
    ):
        out += text(x, y, name, colour=BLUE, code=True, anchor="start", size=11)
    return out + key(500, 260, "[[legs]] copies")


PICTURES: Final[dict[str, Callable[[], str]]] = {
    function.__name__: function
    for function in (
        chain,
        base,
        joint,
        sections,
        gearbox,
        bearing,
        encoder,
        mounting,
        payload,
        tolerance,
        zone,
        sidecar,
        closure,
    )
}


def svg(name: str) -> str:
    """Return a picture as the text of an SVG file."""
    draw = PICTURES[name]
    opening = (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 680 290" width="680" height="290" '
        'role="img">'
    )
    title = f"<title>{(draw.__doc__ or '').removeprefix('Draw ').capitalize()}</title>"
    return (
        f'{opening}{title}<rect width="680" height="290" fill="#ffffff"/>{draw()}</svg>\n'.replace(
            "><", ">\n<"
        )
    )


if __name__ == "__main__":
    for picture in PICTURES:
        (FOLDER / f"{picture}.svg").write_text(svg(picture), encoding="utf-8")
