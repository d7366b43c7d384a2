"""Reading a drawing solves no elastic body and no contact: what it states is checked by geometry,
and solved where a figure needs it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from lostmotion.errors import InputError
from lostmotion.io.part_file import read_gearbox
from lostmotion.laws import perforated_disc
from lostmotion.laws.cycloid import bodies, contact, lobed_wheel

EXAMPLES = Path(__file__).parents[2] / "examples" / "gearbox"


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the names of the laws that are solved from now on."""
    found: list[str] = []

    def counted(module: Any, name: str) -> None:
        law = getattr(module, name)

        def call(*given: object, **more: object) -> object:
            found.append(name)
            return law(*given, **more)

        monkeypatch.setattr(module, name, call)

    counted(perforated_disc, "response")
    counted(bodies, "response")
    counted(bodies, "contact_flexibility")
    counted(bodies, "_edge_flexibility")
    counted(lobed_wheel, "contact_flexibility")
    counted(contact, "load_sharing")
    return found


def thin_webs(folder: Path) -> Path:
    """Return the file of the RV-like drive with thin webs."""
    text = (EXAMPLES / "rv-like.toml").read_text(encoding="utf-8")
    lines = []
    for line in text.splitlines():
        key = line.split("=")[0].strip()
        changed = {
            "ring_radius": 'ring_radius = "57.6 mm ± 3 µm"',
            "disc": 'disc = { holes = { diameter = "33 mm" } }',
        }.get(key)
        lines.append(changed or line)
    path = folder / "thin.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def test_a_drawing_with_thin_webs_is_read_without_solving_its_disc(
    tmp_path: Path, solved: list[str]
):
    """Webs of a fortieth of a hole are accepted by their geometry."""
    part = read_gearbox(thin_webs(tmp_path)).part
    assert part.hole_diameter == pytest.approx(33e-3)  # type: ignore[union-attr]
    assert solved == []


@pytest.mark.parametrize("name", ["rv-like", "two-stage-lobes", "printed"])
def test_no_drawing_is_solved_while_it_is_read(name: str, solved: list[str]):
    """Every example with its members is read without a contact or a body."""
    read_gearbox(EXAMPLES / f"{name}.toml")
    assert solved == []


@pytest.mark.parametrize(
    ("size", "why"), [("34.55 mm", "thinner than a hundredth"), ("36 mm", "no room")]
)
def test_webs_that_no_law_resolves_are_refused_at_once(
    tmp_path: Path, solved: list[str], size: str, why: str
):
    """Holes up to a hundredth of their diameter from the roots, or beyond them, are refused by
    geometry.
    """
    path = thin_webs(tmp_path)
    path.write_text(
        path.read_text(encoding="utf-8").replace('"33 mm"', f'"{size}"'), encoding="utf-8"
    )
    with pytest.raises(InputError, match=why):
        read_gearbox(path)
    assert solved == []
