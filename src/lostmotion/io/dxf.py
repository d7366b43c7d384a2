"""The profiles of a cycloidal gearbox as a DXF drawing: closed polylines in mm, each wheel about
its own centre, named layers.
"""

from __future__ import annotations

import importlib.util
import io
import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import LostmotionError
from lostmotion.laws.cycloid.outline import ring_outline, wheel_outline
from lostmotion.parts.gearbox.cycloidal.temperature import relief_as_drawn

if TYPE_CHECKING:
    from ezdxf.layouts import Modelspace

    from lostmotion.laws.cycloid.outline import DiscOutline
    from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage
    from lostmotion.spatial import Floats

CHORD_ERROR: Final = 0.5e-6
_MM: Final = 1e3
# DXF's own codes: millimetres, and colours by index.
_UNITS: Final = 4
_COLOURS: Final = (5, 1, 3, 6, 4, 8)


def can_draw() -> bool:
    """Return whether ezdxf, which writes the drawing, is installed."""
    return importlib.util.find_spec("ezdxf") is not None


def profile_dxf(gearbox: CycloidalGearbox, name: str) -> bytes:
    """Return the drawing of these wheels as the bytes of a DXF file (R2010, mm).

    Every wheel about its own centre, as with the crank at zero, what is ground off taken off:
    layers DISC_1, DISC_2 … (each turned against the first by its share of a pitch, for the holes
    are common), RING or PINS with PIN_CIRCLE, DISC_BORE, OUTPUT_HOLES or CRANK_CENTRES and
    CRANK_HOLES; those of a first stage begin with FIRST_. With planet pins PINS belong to the
    planet. Corners lie on the true profile and chords within 0.5 µm of it. The same gearbox gives
    the same bytes with one version of ezdxf. Raises LostmotionError where ezdxf is not installed.
    """
    if not can_draw():
        raise LostmotionError(
            "a DXF drawing needs ezdxf, which is not installed\n  pip install 'lostmotion[dxf]'"
        )
    import ezdxf

    before = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True  # no clock, no chance in the file
    try:
        document = ezdxf.new("R2010", units=_UNITS)
        space = document.modelspace()
        worst = _stage(space, gearbox, "")
        if gearbox.first_stage is not None and gearbox.first_stage.kind == "cycloidal":
            worst = max(worst, _stage(space, gearbox.first_stage, "FIRST_"))
        document.header.custom_vars.append("gearbox", name)
        document.header.custom_vars.append("largest chord error in µm", f"{worst * 1e6:.3f}")
        # ezdxf itself adds them out of a set, in any order
        for kind in sorted(document.entitydb.dxf_types_in_use()):
            document.classes.add_class(kind)
        out = io.StringIO()
        document.write(out)
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before
    return out.getvalue().encode(document.output_encoding, errors="dxfreplace")


def _stage(space: Modelspace, part: CycloidalStage, prefix: str) -> float:
    """Draw the wheels of one stage; gives the largest chord error (m)."""
    stage = part.stage
    turns = (
        -2
        * math.pi
        / part.discs
        / (stage.pins if stage.has_planet_pins else stage.lobes)
        * np.arange(part.discs)
    )
    wheel = wheel_outline(stage, relief_as_drawn(part), CHORD_ERROR)
    worst = wheel.chord_error
    if stage.has_planet_pins:
        _polyline(space, wheel, f"{prefix}RING", 0.0)
        for k, turn in enumerate(turns, 1):
            _circles(
                space,
                _around(stage.pins, stage.ring_radius, turn),
                stage.pin_radius,
                f"{prefix}PINS_{k}",
            )
    else:
        for k, turn in enumerate(turns, 1):
            _polyline(space, wheel, f"{prefix}DISC_{k}", turn)
        if stage.kind == "ring pins":
            _circles(
                space, _around(stage.pins, stage.ring_radius), stage.pin_radius, f"{prefix}PINS"
            )
        else:
            ring = ring_outline(stage, CHORD_ERROR)
            worst = max(worst, ring.chord_error)
            _polyline(space, ring, f"{prefix}RING", 0.0)
    middle = np.zeros((1, 2))
    _circles(space, middle, stage.ring_radius, f"{prefix}PIN_CIRCLE")
    if part.disc_bore_radius is not None:
        _circles(space, middle, part.disc_bore_radius, f"{prefix}DISC_BORE")
    if part.ring_outer_radius is not None:
        _circles(space, middle, part.ring_outer_radius, f"{prefix}RING_OUTSIDE")
    _output(space, part, prefix)
    return worst


def _output(space: Modelspace, part: CycloidalStage, prefix: str) -> None:
    """Draw the holes that the output pins go through, as wide as pin, twice the eccentricity and
    clearance; or the places of crankshafts.
    """
    pins, eccentric = part.output_pins, part.eccentric
    if pins is not None:
        layer, places = f"{prefix}OUTPUT_HOLES", _around(pins.count, pins.circle_radius)
        if pins.outer_diameter is not None:
            _circles(
                space,
                places,
                (pins.outer_diameter + pins.clearance.nominal) / 2 + part.stage.eccentricity,
                layer,
            )
        else:
            _points(space, places, layer)
    elif eccentric.circle_radius is not None:
        places = _around(eccentric.cranks, eccentric.circle_radius)
        _points(space, places, f"{prefix}CRANK_CENTRES")
        if part.disc.holes is not None:
            _circles(space, places, part.disc.holes.diameter / 2, f"{prefix}CRANK_HOLES")


def _around(count: int, radius: float, start: float = 0.0) -> Floats:
    at = start + 2 * math.pi * np.arange(count) / count
    return radius * np.stack([np.cos(at), np.sin(at)], axis=-1)


def _layer(space: Modelspace, name: str) -> dict[str, str]:
    layers = space.doc.layers
    if name not in layers:
        layers.add(name, color=_COLOURS[len(layers) % len(_COLOURS)])
    return {"layer": name}


def _polyline(space: Modelspace, outline: DiscOutline, layer: str, turn: float) -> None:
    cos, sin = math.cos(turn), math.sin(turn)
    points = _MM * outline.points @ np.array([[cos, sin], [-sin, cos]])
    space.add_lwpolyline(points.tolist(), close=True, dxfattribs=_layer(space, layer))


def _circles(space: Modelspace, places: Floats, radius: float, layer: str) -> None:
    for place in _MM * places:
        space.add_circle(tuple(place.tolist()), _MM * radius, dxfattribs=_layer(space, layer))


def _points(space: Modelspace, places: Floats, layer: str) -> None:
    for place in _MM * places:
        space.add_point(tuple(place.tolist()), dxfattribs=_layer(space, layer))
