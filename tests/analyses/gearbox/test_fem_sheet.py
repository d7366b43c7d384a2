"""A gearbox by finite elements: its tables, pictures and files, and what cannot be meshed."""

from __future__ import annotations

import base64
import importlib.util
import re
import struct
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.gearbox.page.fem import fem_plots
from lostmotion.errors import InputError, LostmotionError
from lostmotion.io.vtu import vtu
from lostmotion.laws.cycloid.drive import LEAST_ARM, loaded_disc, nominal_gaps
from lostmotion.laws.cycloid.finite_elements.contours import contacts
from lostmotion.laws.cycloid.finite_elements.wheel import Field
from lostmotion.laws.cycloid.geometry import arms, first_contact_angle, flank, pin_angles
from lostmotion.parts.gearbox.cycloidal import finite_elements
from lostmotion.reporting.folder import FILES
from tests.reporting.chart_texts import texts

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.bodies import ElasticBody
    from lostmotion.laws.cycloid.contact import LoadSharing
    from lostmotion.laws.cycloid.finite_elements.stage import Loaded
    from lostmotion.laws.cycloid.stage import Stage
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage

EXAMPLES = Path(__file__).parents[3] / "examples" / "gearbox"


def arrays_of(content: bytes) -> tuple[int, int, dict[str, np.ndarray]]:
    """Return the numbers of points and cells of a VTU file, and its arrays by name."""
    piece = ET.fromstring(content).find("UnstructuredGrid/Piece")  # noqa: S314 - our own file
    out = {}
    for array in piece.iter("DataArray"):
        data = base64.b64decode(array.text)
        (length,) = struct.unpack("<I", data[:4])
        assert length == len(data) - 4
        kind = {"Float32": "<f4", "Int32": "<i4", "UInt8": "u1"}[array.get("type")]
        out[array.get("Name")] = np.frombuffer(data[4:], kind).reshape(
            -1, int(array.get("NumberOfComponents", "1"))
        )
    return int(piece.get("NumberOfPoints")), int(piece.get("NumberOfCells")), out


def check(content: bytes) -> dict[str, np.ndarray]:
    """Check that a VTU file holds triangles of its own points, and return its arrays."""
    points, cells, arrays = arrays_of(content)
    assert (arrays["types"] == 5).all()
    np.testing.assert_array_equal(arrays["offsets"][:, 0], 3 * np.arange(1, cells + 1))
    assert len(arrays["connectivity"]) == 3 * cells
    assert arrays["connectivity"].min() == 0
    assert arrays["connectivity"].max() == points - 1
    assert all(
        len(arrays[name]) == points
        for name in arrays
        if name not in {"connectivity", "offsets", "types"}
    )
    return arrays


def test_two_triangles_are_read_back_from_their_file():
    """A VTU file contains points, triangles, scalars and vectors."""
    points = np.array([[0.0, 0], [1, 0], [0, 1], [1, 1]])
    arrays = check(
        vtu(points, np.array([[0, 1, 2], [1, 3, 2]]), {"heat": points[:, 0], "shift": points})
    )
    np.testing.assert_array_equal(arrays["points"], np.column_stack([points, np.zeros(4)]))
    np.testing.assert_array_equal(arrays["connectivity"][:, 0], [0, 1, 2, 1, 3, 2])
    np.testing.assert_array_equal(arrays["shift"][:, :2], points)
    np.testing.assert_array_equal(arrays["heat"][:, 0], points[:, 0])


def test_finite_elements_without_ngsolve_name_the_extra(monkeypatch):
    """Without NGSolve the message says how to install it, before anything is computed."""
    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "ngsolve" else found(name)
    )
    with pytest.raises(LostmotionError, match=r"pip install 'lostmotion\[fem\]'"):
        lostmotion.gear(EXAMPLES / "printed.toml", fem=True)


def test_gearboxes_without_a_meshable_drawing_are_refused(tmp_path):
    """Gearboxes by stated figures and discs without an inner radius cannot be meshed."""
    stated = tmp_path / "stated.toml"
    stated.write_text('[gearbox]\nstiffness = "50 N m/arcmin"\n')
    with pytest.raises(InputError, match="a gearbox with a drawing"):
        lostmotion.gear(stated, fem=True, torque="100 N m")
    solid = tmp_path / "solid.toml"
    lines = (
        (EXAMPLES / "printed.toml")
        .read_text("utf-8")
        .replace('"disc_bore_radius",', "")
        .splitlines()
    )
    solid.write_text("\n".join(line for line in lines if not line.startswith("disc_bore_radius")))
    with pytest.raises(InputError, match="several cranks"):
        lostmotion.gear(EXAMPLES / "rv-like.toml", fem=True)
    with pytest.raises(InputError, match="disc_bore_radius"):
        lostmotion.gear(solid, fem=True)


def test_order_and_refinement_reach_the_mesh_and_are_limited(monkeypatch):
    """Order and refinement are handed to the mesh, each includes the finite elements, and orders
    from 2 to 4 are possible.
    """

    def asked(*_args: object, order: int, intervals: int, **_options: object) -> None:
        raise ValueError(f"order {order}, {intervals} intervals")

    monkeypatch.setattr(finite_elements, "check_installed", lambda: None)
    monkeypatch.setattr(finite_elements, "loaded_stage", asked)
    for given, expected in (
        ({"fem_order": 3}, "order 3, 5 intervals"),
        ({"fem_refinement": 2}, "order 2, 10 intervals"),
        ({"fem": True}, "order 2, 5 intervals"),
    ):
        with pytest.raises(InputError, match=rf"output stage cannot be meshed[^:]*: {expected}"):
            lostmotion.gear(EXAMPLES / "printed.toml", gearboxes=2, **given)
    with pytest.raises(InputError, match="fem_order"):
        lostmotion.gear(EXAMPLES / "printed.toml", fem_order=5)


def by_elements(name: str) -> finite_elements.FiniteElements:
    """Return a stage of one square plate, whose stress is largest at one corner."""
    points, loaded = (
        np.array([[0.0, 0], [0.03, 0], [0.03, 0.03], [0, 0.03]]),
        (np.array([0.5, 4.0]), np.array([[0.0, 5, 0], [2e7, 9, 3e7]])),
    )
    field = Field(
        points,
        np.array([[0, 1, 2], [0, 2, 3]]),
        1e-5 * points,
        np.array([1e6, 1e6, 3.3e7, 1e6]),
        np.array([1e-4, 1e-4, 1e-2, 1e-4]),
    )
    contacts = SimpleNamespace(
        peak=loaded[1],
        forces=1e-6 * loaded[1],
        half_width=np.full((2, 3), 2e-3),
        theta=np.array([0.1, 0.5, 1.0]),
        place=np.array([0, 0.01j, 0.028 + 0.03j]),
    )
    return finite_elements.FiniteElements(
        name=name,
        torque=loaded[0],
        rotation=np.array([[1e-3, 3e-3], [2e-3, 4e-3]]),
        rotation_3d=None,
        error_3d=None,
        unknowns=8,
        error=np.array([1e-6, 1e-6]),
        stiffness=np.array([500.0, 1000.0]),
        stress=np.array([4e6, 3.3e7]),
        strain=np.array([1e-3, 1e-2]),
        loaded=contacts,
        stage=SimpleNamespace(kind="ring pins", eccentricity=1e-3),
        fields=[field],
        turn=0.0,
        not_meshed="",
        most_stressed=finite_elements.Largest(3.3e7, 0.03 + 0.03j, "disc"),
        most_strained=finite_elements.Largest(1e-2, 0.03 + 0.03j, "disc"),
    )


def test_finite_elements_are_answered_first_and_their_maximum_is_marked():
    """Who asks for finite elements reads their figures in headline and cards, has their tables
    before the inputs, and sees where the maximum is.
    """
    gear = replace(
        lostmotion.gear(EXAMPLES / "printed.toml", gearboxes=2), fem=(by_elements("output stage"),)
    )
    sheet = gear.sheet
    assert (
        "turns by 10.3 to 13.8 arcmin beyond its play under 4 N m; the peak pressure is "
        "0.0300 GPa at θ = 57.3°"
    ) in sheet.verdict
    assert "the largest von Mises stress 33.0 MPa in the disc at x 30 mm, y 30 mm" in sheet.verdict
    cards = {card.title: card.number for card in sheet.cards}
    assert cards["largest von Mises stress"] == "33.0 MPa"
    assert cards["peak pressure by finite elements"] == "0.0300 GPa"
    keys = [section.key for section in sheet.sections]
    assert (
        keys.index("fem") < keys.index("fem-lobes") < min(keys.index("built"), keys.index("inputs"))
    )
    marked = {plot.key: texts(plot) for plot in fem_plots(gear.fem)}
    assert "largest, 33.0 MPa, in the disc" in marked["fem-stress"]
    assert "largest, 10000 µm/m, in the disc" in marked["fem-strain"]
    assert "largest stress, 33.0 MPa, in the disc" in marked["fem-contact"]
    both = replace(gear, fem=(by_elements("output stage"), by_elements("first stage"))).sheet
    assert "largest von Mises stress, first stage" in {card.title for card in both.cards}


def forces_by_law(part: CycloidalStage, torque: float) -> np.ndarray:
    """Return the forces (N,) on the lobes of a disc by the contact law on elastic bodies. Gaps are
    those of the profiles turned by its rotation, for the law itself is of first order in this.
    """
    start, made = np.zeros(1), contacts(part.stage, 0.0)
    gap = nominal_gaps(part.drive, start)

    def solved(more: np.ndarray) -> LoadSharing:
        return loaded_disc(part.drive, torque, start, gap + more, rigid_eccentric=True)

    turn = solved(np.zeros(part.stage.pins)).rotation.item()
    profile = flank(part.stage, np.linspace(0, 2 * np.pi, 40_001))[0] @ np.array([1, 1j])
    turned = made.planet + profile * np.exp(1j * (made.turn + turn))
    apart = np.array([np.abs(turned - pin).min() for pin in made.pin]) - part.stage.pin_radius
    return solved(apart + made.arm * turn).forces[0, 0, 0]


@pytest.mark.slow
def test_a_report_shows_stress_strain_and_the_rotation_beside_the_papers_conversion(
    tmp_path, monkeypatch
):
    """Four pictures and two VTU files; the paper's angle is the strain in arcmin, several times the
    rotation in 2-D or 3-D. Planets have no mesh.
    """
    monkeypatch.setattr(finite_elements, "_INTERVALS", 4)  # of 5: in three quarters of the time
    file = tmp_path / "with-planets.toml"
    planets = (
        '\n[gearbox.first_stage]\nkind = "planetary"\nsun_teeth = 16\nplanet_teeth = 38\nmodule = '
        '"0.5 mm"\n'
    )
    file.write_text((EXAMPLES / "printed.toml").read_text("utf-8") + planets, "utf-8")
    gear = lostmotion.gear(file, fem_3d=True, gearboxes=2, torque="3 N m")
    section = next(each for each in gear.result()["sections"] if each["key"] == "fem")
    for row in section["rows"]:
        strain_rotation, stress_rotation, solid_rotation, _, _, _, strain, angle = (
            figure["value"] for figure in row["figures"]
        )
        assert angle == pytest.approx(strain, rel=0.01)
        assert strain_rotation < solid_rotation < stress_rotation < angle
    assert "3-D is coarse" in section["note"]
    stated = re.findall(r"two meshes differ by ([\d., ]+) % at these torques", section["note"])
    (stage,) = gear.fem
    for shares, errors, rotations in zip(
        stated,
        (stage.error, stage.error_3d),
        (stage.rotation[0], stage.rotation_3d),
        strict=True,
    ):
        found = [float(share) / 100 for share in shares.split(", ")]
        np.testing.assert_allclose(found, errors / rotations, rtol=0.05)
    assert "not meshed: the planetary first stage" in section["note"]
    folder = gear.report(tmp_path / "report")
    page = (folder / "report.html").read_text("utf-8")
    assert all(
        f'id="plot-{key}"' in page
        for key in ("fem-stress", "fem-strain", "fem-contact", "fem-angle")
    )
    for name in ("planet.vtu", "ring.vtu"):
        arrays = check((folder / name).read_bytes())
        assert 0 < arrays["von_mises_Pa"].max() <= 1.2 * gear.fem[0].stress[-1]
    assert gear.fem[0].most_stressed.value == pytest.approx(gear.fem[0].stress[-1])
    body = gear.fem[0].fields[("disc", "ring").index(gear.fem[0].most_stressed.body)]
    place = gear.fem[0].most_stressed.place
    near = np.linalg.norm(body.points - [place.real, place.imag], axis=1) < 3e-4
    assert body.von_mises[near].max() > 0.8 * body.von_mises.max()
    # the finite elements take the rotation to second order, which under the largest torque leaves
    # lobe 1 with less than the law's
    for torque, found, within in zip(
        gear.fem[0].torque, gear.fem[0].loaded.forces, (0.06, 0.06, 0.06, 0.12), strict=True
    ):
        expected = forces_by_law(gear.gearbox, torque / gear.gearbox.discs)
        np.testing.assert_allclose(found, expected, rtol=0, atol=within * expected.max())


@pytest.mark.slow
def test_a_cycloidal_first_stage_is_solved_under_its_share_of_the_torque(tmp_path, monkeypatch):
    """The first stage carries the torque over the ratio of the second; its rotation at the output
    agrees with the contacts on elastic bodies.

    To 1 % in the second stage. In the first, webs of 2 mm are left below valleys of 3 mm between
    its lobes, where the law is good to 2 %. Plane stress is not compared, so not solved.
    """
    solve, in_strain = finite_elements.loaded_stage, {}

    def strain_alone(stage: Stage, disc: ElasticBody, *args: object, **options: object) -> Loaded:
        if disc.plane == "strain":
            in_strain[stage] = solve(stage, disc, *args, **options)
        return in_strain[stage]

    monkeypatch.setattr(finite_elements, "loaded_stage", strain_alone)
    monkeypatch.setattr(finite_elements, "_LEVELS", (0.5, 1.0))
    monkeypatch.setattr(finite_elements, "_INTERVALS", 3)  # of 5: in half the time
    file = tmp_path / "two-stages.toml"
    drawing = (
        (EXAMPLES / "two-stage-lobes.toml")
        .read_text("utf-8")
        .replace('form = "lobe envelope"', 'form = "ring pins"')
    )
    file.write_text(drawing.replace('roller = "6 µm ± 2 µm"', 'roller = "1 µm"'), "utf-8")
    gear = lostmotion.gear(file, fem=True, gearboxes=2)
    main, first = gear.fem
    steps, start = abs(gear.gearbox.steps), np.zeros(1)
    for found, part, per_output, within in (
        (main, gear.gearbox, 1.0, 0.01),
        (first, gear.gearbox.first_stage, 1 / steps, 0.02),
    ):
        gap = nominal_gaps(part.drive, start)
        torque = per_output * gear.torque / part.discs
        turned = loaded_disc(part.drive, torque, start, gap, rigid_eccentric=True).rotation.item()
        play = first_contact_angle(
            part.stage, pin_angles(part.stage, start), gap[:, 0], LEAST_ARM
        ).item()
        assert found.rotation[0, -1] == pytest.approx(per_output * (turned - play), rel=within)
        assert found.loaded.forces[-1] @ arms(
            part.stage, pin_angles(part.stage, start)[0]
        ) == pytest.approx(torque, rel=0.002)
        expected = forces_by_law(part, torque)
        # the law spreads the forces over the lobes around holes, which pins load from one side
        np.testing.assert_allclose(
            found.loaded.forces[-1], expected, rtol=0, atol=0.2 * expected.max()
        )
    keys = [section["key"] for section in gear.result()["sections"]]
    assert [key for key in keys if key.startswith("fem")] == [
        "fem",
        "fem-lobes",
        "fem-first",
        "fem-first-lobes",
    ]
    assert (
        {"planet.vtu", "ring.vtu", "first-stage-planet.vtu", "first-stage-ring.vtu"}
        <= gear.files().keys()
        <= set(FILES)
    )
