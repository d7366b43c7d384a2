"""The viewer of a page: the arm in three dimensions, which the reader turns, cuts and zooms.

Its script is `viewer.js`, built from the folder `viewer` of the repository. It lies compressed in
the page. A short loader unpacks and runs it. Without JavaScript or WebGL, and on paper, the page
shows the pictures that stand below the viewer.
"""

from __future__ import annotations

import base64
import functools
import gzip
import json
from importlib.resources import files
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.mechanism.state import state_of
from lostmotion.printed import round_number
from lostmotion.reporting.map_chart import class_names
from lostmotion.reporting.page.text import escaped, spaced

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.reporting.arm_scene import ArmScene, Cells
    from lostmotion.spatial import Floats

# Digits of a coordinate in m: 0.1 mm.
_PLACES: Final = 4
# A square of the floor over the size of the picture.
_SQUARE: Final = 1 / 12
_CUTS: Final = (
    ("arm", "through the arm"),
    ("x", "across x"),
    ("y", "across y"),
    ("z", "across z"),
    ("all", "none"),
    ("none", "arm alone"),
)
_LABEL: Final = (
    "The arm in three dimensions, as described below. The arrow keys turn it, plus and minus "
    "zoom, 0 shows it as at first."
)
# The policy of the page allows a script by its text, so that of the viewer runs only if it is what
# this package was built with.
_LOADER: Final = """addEventListener("DOMContentLoaded",async()=>{
const packed=Uint8Array.from(atob(document.getElementById("viewer-code").textContent),each=>each.charCodeAt(0));
const script=document.createElement("script");
script.textContent=await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
document.body.append(script)})"""  # noqa: E501


def scripts() -> tuple[str, ...]:
    """Return the scripts of a page with a viewer, for its policy: the loader, and the viewer
    itself.
    """
    return _LOADER, _code()


def script_elements() -> str:
    """Return the elements that hold the viewer's script, compressed, and the loader."""
    return (
        f'<script type="text/plain" id="viewer-code">{_packed(_code().encode())}</script>\n'
        f"<script>{_LOADER}</script>\n"
    )


def viewer(scene: ArmScene) -> str:
    """Return the viewer of a scene with its controls and legend. It is hidden until the script has
    found that it can draw.
    """
    buttons = "".join(
        (
            '<button type="button" '
            f'aria-pressed="{"false" if k else "true"}">{escaped(pose.name)}</button>'
        )
        for k, pose in enumerate(scene.poses)
    )
    group = (
        f'<span role="group" aria-label="Pose of the arm">{buttons}</span>\n'
        if len(scene.poses) > 1
        else ""
    )
    cuts = [cut for cut in _CUTS if not (scene.flat and cut[0] == "arm")]
    if scene.flat:
        cuts.sort(key=lambda cut: cut[0] != "z")
    choices = "".join(f'<option value="{value}">{name}</option>' for value, name in cuts)
    legend = _legend(scene.cells) if scene.cells is not None else ""
    return f"""<div class="viewer" data-label="{escaped(_LABEL)}" hidden>
<div class="stage"></div>
{legend}<div class="controls">{group}<span class="cut"><label>cut <select>{choices}</select></label>
<label>at <input type="range" step="10"> <output></output></label></span></div>
<p class="shown quiet" aria-live="polite">{spaced(scene.poses[0].words)}</p>
<script type="application/json">{_data(scene)}</script></div>
"""


def _legend(cells: Cells) -> str:
    names = "".join(
        f'<span><i class="k{k}"></i>{spaced(name)}</span>'
        for k, name in enumerate(class_names(cells.limits))
    )
    return f'<p class="legend"><b>{escaped(cells.what)} [{escaped(cells.unit)}]</b>{names}</p>\n'


def _data(scene: ArmScene) -> str:
    """Return what the script draws, as JSON in which no tag can begin; lengths in m. The arm and
    its error lie between low and high.
    """
    at = [state_of(scene.arm, pose.q).frames[:, 0] for pose in scene.poses]
    tools = [each[-1, :3, 3] for each in at]
    bodies = scene.arm.bodies
    corners = [body.corners_at(each[body.place]) for each in at for body in bodies]
    ends = [tool + scene.factor * pose.error for tool, pose in zip(tools, scene.poses, strict=True)]
    seen = np.concatenate([*corners, ends])
    low, high = seen.min(axis=0), seen.max(axis=0)
    size = float(np.linalg.norm(high - low)) or 1.0
    if scene.cells is not None:
        size = max(size, scene.cells.edge * float(np.linalg.norm(scene.cells.classes.shape)))
    feet = [
        float(each[:, 2].min())
        for each, body in zip(corners, len(at) * bodies, strict=True)
        if body.kind == "base"
    ]
    data: dict[str, Any] = {
        "size": round(size, _PLACES),
        "low": _rounded(low),
        "high": _rounded(high),
        "floor": {"z": round(min([0.0, *feet]), _PLACES), "cell": round_number(_SQUARE * size)},
        "bodies": [
            {
                "kind": "point" if body.name == "tool point" else body.kind,
                "form": body.form,
                "near": _rounded(body.near),
                "far": _rounded(body.far),
                "length": round(body.length, _PLACES),
            }
            for body in bodies
        ],
        "poses": [
            {
                "words": pose.words,
                "bodies": [_rounded((each[body.place] @ body.pose)[:3].ravel()) for body in bodies],
                "tool": _rounded(tool),
                "error": _rounded(scene.factor * pose.error),
                "axes": [_rounded(axis) for axis in scene.factor * pose.axes],
            }
            for pose, each, tool in zip(scene.poses, at, tools, strict=True)
        ],
        "cells": None if scene.cells is None else _cells(scene.cells),
    }
    return json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False).replace(
        "<", "\\u003c"
    )


def _cells(cells: Cells) -> dict[str, Any]:
    """Return the cells: a byte for each, x fastest, 0 where the tool never is, else its class from
    1.
    """
    codes = (cells.classes + 1).astype(np.uint8).tobytes(order="F")
    return {
        "edge": round(cells.edge, 6),
        "low": _rounded(cells.low),
        "shape": list(cells.classes.shape),
        "classes": _packed(codes),
    }


def _rounded(values: Floats | Sequence[float]) -> list[float]:
    return [round(float(value), _PLACES) + 0.0 for value in values]


def _packed(content: bytes) -> str:
    """Return bytes compressed by gzip, as base64 text; no clock is read."""
    return base64.b64encode(gzip.compress(content, mtime=0)).decode()


@functools.cache
def _code() -> str:
    return files(__package__).joinpath("viewer.js").read_text(encoding="utf-8")
