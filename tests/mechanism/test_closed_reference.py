"""Closed chains against figures that were found by routes without a Jacobian: perturbed closed
forms (circles, distances) with differences, and statics by virtual work.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.mechanism.closed_chains import (
    at,
    delta,
    five_bar,
    hexapod,
    hexapod_legs,
    moved,
    palletiser,
    three_rrr,
    wrench,
)

X, Y, TURN_Z = (0, 0, 0, 1, 0, 0), (0, 0, 0, 0, 1, 0), (0, 0, 1, 0, 0, 0)
PRINTED = 6e-7


def near(found: object, printed: object) -> None:
    """Check a figure to its printed digits."""
    np.testing.assert_allclose(found, printed, atol=PRINTED, rtol=0)


def test_the_tool_of_a_five_bar_moves_as_two_circles_do():
    """Every drive, link and motor moves the tool of a five-bar as intersections of circles."""
    state = at(five_bar(), (2.2, 0.9))
    near(state.frames[-1, 0, :2, 3], (0.108035, 0.510171))
    for place, twist, printed in (
        ("m1", TURN_Z, (-0.194735, -0.153246)),
        ("m2", TURN_Z, (-0.191617, 0.158719)),
        ("m1.tip", X, (0.198749, 0.156404)),
        ("m2.tip", X, (-0.182110, 0.150845)),
        ("e1.tip", X, (0.803897, 0.632621)),
        ("e2.tip", X, (-0.787805, 0.652551)),
        ("m2.seat", X, (0.487193, -0.403550)),
        ("m2.seat", Y, (-0.619096, 0.512807)),
    ):
        near(moved(state, place, *twist)[3:5], printed)


def test_the_pins_of_a_five_bar_carry_what_virtual_work_has():
    """Drives and pins hold 2 kg at the tool and the weight of the links."""
    state = at(five_bar(), (2.2, 0.9), gravity=np.array([0, -9.80665, 0]))
    near(state.torques[0], (-3.540672, 3.671957))
    for place, printed in (
        ("m1", 15.412234),
        ("e1", 14.417371),
        ("m2", 15.871296),
        ("e2", 14.861590),
        ("pin", 13.321713),
    ):
        near(np.linalg.norm(wrench(state, place)[3:]), printed)


def test_a_three_legged_planar_stage_moves_as_three_distances_have_it():
    """Drives, links, motors and corners of a 3-RRR stage move its platform."""
    state = at(three_rrr(), (-0.387773, 1.561341, 3.472764))
    np.testing.assert_allclose(state.frames[-1, 0, :2, 3], (0.03, 0.05), atol=2e-6)
    rows = (
        ("1_crank", TURN_Z, (0.158736, 0.066550, -0.735115)),
        ("2_crank", TURN_Z, (-0.185335, 0.170613, -0.724657)),
        ("3_crank", TURN_Z, (-0.016946, -0.225375, -0.686740)),
        ("1_crank.tip", X, (0.403672, 0.169240, -1.869428)),
        ("1_elbow.tip", X, (-0.566068, -0.237325, 2.621494)),
        ("2_crank.tip", X, (-0.260457, 0.239767, -1.018380)),
        ("3_elbow.tip", X, (0.052401, 0.696911, 2.123553)),
        ("1_crank.seat", X, (0.523757, 0.219586, -2.425548)),
    )
    for place, twist, printed in rows:
        np.testing.assert_allclose(moved(state, place, *twist)[[3, 4, 2]], printed, atol=1e-5)


def test_a_delta_moves_as_six_distances_have_it():
    """Drives, arms, base and single rods move and tilt the platform of a delta."""
    state = at(delta(), np.radians((10.427142, 31.697120, 21.140623)))
    np.testing.assert_allclose(state.frames[-1, 0, :3, 3], (0.05, -0.03, -0.42), atol=1e-8)
    turn_y, along = (0, 1, 0, 0, 0, 0), (0, 0, 0, 0, 0, -1)
    none = (0, 0, 0)
    for place, twist, turn, shift in (
        ("1_arm", turn_y, none, (-0.162315, -0.003698, -0.102199)),
        ("2_arm", turn_y, none, (0.101336, -0.171240, -0.062312)),
        ("1_arm.tip", X, none, (0.401674, 0.009152, 0.252907)),
        ("1_arm.seat", X, none, (0.541924, 0.012347, 0.341213)),
        ("1a_rod.tip", along, (-9.204914, 0.538281, 4.419739), (-0.428477, 0.520606, -0.334377)),
        ("1b_rod.tip", along, (9.204914, -0.538281, -4.419739), (-0.478834, -0.541278, -0.236896)),
        ("2_arm.seat", TURN_Z, (0.302742, -0.612754, 0.405282), (-0.047937, -0.014484, -0.001725)),
    ):
        near(moved(state, place, *twist), (*turn, *shift))
    near(state.torques[0], (-2.575590, -1.767434, -2.206435))
    axial = [-wrench(state, f"{rod}_rod.tip")[5] for rod in ("1a", "1b", "2a", "2b", "3a", "3b")]
    near(axial, (5.510348, 3.789615, 3.735987, 1.388221, 1.587390, 5.711661))


HEXAPOD = """
-1.616314 1.625816 1.143336 -0.238713 0.255644 -1.205212
-0.660869 -0.389324 -1.183482 1.689032 1.517467 -0.974827
-1.770757 1.854197 -1.960163 1.901930 -1.781870 1.759787
-0.573864 -0.699986 0.888227 -0.228848 -0.245980 0.900345
-0.630899 0.653642 -0.276281 -0.832535 0.929444 0.212083
0.248117 0.161624 0.160782 0.242457 0.137179 0.142086
"""


def test_a_hexapod_moves_as_its_six_distances_have_it():
    """The legs of a Gough-Stewart platform move it as the inverse of their Plücker rows, hold its
    weight, and stiffen it.
    """
    arm = hexapod("20 N/µm")
    state = at(arm, hexapod_legs((0.02, 0.03, 0.5), 0.1))
    near(state.q[0], (0.520004, 0.560700, 0.568857, 0.543861, 0.555950, 0.541216))
    np.testing.assert_allclose(state.frames[-1, 0, :3, 3], (0.02, 0.03, 0.5), atol=1e-12)
    legs = np.array([moved(state, f"{k}_leg", 0, 0, 0, 0, 0, 1) for k in range(1, 7)]).T
    near(legs, np.array(HEXAPOD.split(), dtype=float).reshape(6, 6))
    held = (61.415671, 45.135624, 45.539997, 58.042840, 32.497887, 35.796005)
    near(state.torques[0], held)
    printed = (3036623.55, 3138281.99, 1002584.44, 10052714.99, 10145918.79, 99801366.22)
    assert np.diag(np.linalg.inv(state.compliance[0])) == pytest.approx(printed, rel=1e-8)


def test_a_palletiser_moves_and_carries_as_circles_in_its_plane_have_it():
    """Drives and rods of a palletiser with three parallelograms, over-constrained nine times, move
    its tool in the plane; all three of one length cancel in the level.
    """
    state = at(palletiser(), (0.3, 1.9, 2.9))
    near(state.frames[-1, 0, :3, 3], (1.221493, 0.377852, 1.280441))
    out, across = np.array([np.cos(0.3), np.sin(0.3), 0]), np.array([np.sin(0.3), -np.cos(0.3), 0])

    def plane(place: str, *twist: float) -> np.ndarray:
        found = moved(state, place, *twist)
        return np.array([out @ found[3:], found[5], across @ found[:3]])

    raised = (0, -1, 0, 0, 0, 0)
    shorter = (0, 0, 0, -1, 0, 0)
    for place, twist, printed in (
        ("arm", raised, (-0.993615, -0.339454, 0)),
        ("crank", raised, (0.263174, 1.068054, 0)),
        ("arm.tip", X, (3.138229, 6.627132, 10.271730)),
        ("elbow.tip", X, (2.000869, 0.584679, 4.119642)),
        ("rod.tip", X, (-0.893586, -3.626486, 0)),
        ("crank.tip", X, (-0.482806, -1.959399, 0)),
        ("heel.tip", shorter, (0.482806, 1.959399, 0)),
        ("level 1.tip", X, (-2.567932, -2.054346, -10.271730)),
        ("level 2.tip", X, (-1.029910, -0.823928, -4.119642)),
    ):
        near(plane(place, *twist), printed)
    np.testing.assert_allclose(state.torques[0], (0, -729.030636, 1503.975716), atol=1e-6)
    axial = [-wrench(state, f"{rod}.tip")[3] for rod in ("rod", "level 1", "level 2")]
    np.testing.assert_allclose(np.abs(axial), (5286.7742, 2110.5446, 849.1127), atol=6e-5)


def box(width: float, height: float, wall: float) -> dict:
    """Return a box, mm, as a section of stated constants: shear factor 0.44, torsion by Bredt."""
    b, h, t = width / 1e3, height / 1e3, wall / 1e3
    inner, around = (b - 2 * t) * (h - 2 * t), (b - t) * (h - t)
    return constants(
        b * h - inner,
        (b * h**3 - (b - 2 * t) * (h - 2 * t) ** 3) / 12,
        (h * b**3 - (h - 2 * t) * (b - 2 * t) ** 3) / 12,
        2 * around**2 * t / (b + h - 2 * t),
        0.44,
    )


def tube(outer: float, wall: float) -> dict:
    """Return a tube, mm, with a shear factor of 0.5."""
    inner, outer = (outer - 2 * wall) / 1e3, outer / 1e3
    second = np.pi * (outer**4 - inner**4) / 64
    return constants(np.pi * (outer**2 - inner**2) / 4, second, second, 2 * second, 0.5)


def constants(area: float, i_y: float, i_z: float, torsion: float, shear: float) -> dict:
    """Return a section of stated constants, SI."""
    return {
        "kind": "custom",
        "area": f"{area!r} m^2",
        "i_y": f"{i_y!r} m^4",
        "i_z": f"{i_z!r} m^4",
        "torsion": f"{torsion!r} m^4",
        "shear_y": f"{shear}",
        "shear_z": f"{shear}",
    }


def metal(young: float, shear: float) -> dict:
    """Return a material by its moduli, GPa."""
    stiff = {"young": f"{young} GPa", "poisson": young / (2 * shear) - 1}
    return {"name": "metal", **stiff, "density": "7850 kg/m^3"}


def test_an_elastic_palletiser_deflects_as_a_displacement_method_has_it():
    """Compliance of a palletiser with elastic members, over-constrained nine times, and what errors
    out of its plane do to it: a frame solver by displacements, 23 nodes.
    """
    steel = metal(210, 81)

    def member(section: dict, angle: float | None = None) -> dict:
        up = {} if angle is None else {"up": [-np.sin(angle), 0.0, np.cos(angle)]}
        return {"section": section, "material": steel, **up}

    stub, bearing = box(40, 60, 6), {"kind": "crossed roller"}
    bearing |= {"moment_stiffness": "2e6 N m/rad", "radial_stiffness": "8e8 N/m"}
    bearing |= {"axial_stiffness": "5e8 N/m"}
    arm = palletiser(
        {
            "arm": member(box(160, 220, 8)),
            "elbow": member(box(140, 180, 7)),
            "heel": member(box(140, 180, 10), np.pi),
            "crank": member(box(80, 160, 12)),
            "lug": member(box(60, 80, 8), 2.3),
            "horn": member(stub, np.pi / 2),
            "first": member(stub, 2.3),
            "second": member(stub, np.pi / 2),
            "rod": member(tube(70, 8)),
            "level 1": member(tube(45, 5)),
            "level 2": member(tube(45, 5)),
            "joint turn": {"gearbox": {"stiffness": "3.5e6 N m/rad"}},
            "joint arm": {"gearbox": {"stiffness": "3e6 N m/rad"}},
            "joint crank": {"gearbox": {"stiffness": "3e6 N m/rad"}},
            "joint elbow": {"bearing": bearing},
        }
    )
    state = at(arm, (0.3, 1.9, 2.9))
    printed = (1.433442e-6, 4.180447e-6, 1.351017e-6, 8.100916e-7, 1.837191e-6, 9.060539e-7)
    assert np.diag(state.compliance[0]) == pytest.approx(printed, rel=4e-7)
    tilted = moved(state, "arm.tip", 0, 0, 1e-4, 0, 0, 0) * 1e6
    near(tilted, (-75.646311, -23.400146, -34.836831, 24.973614, -80.732905, 0))
    np.testing.assert_allclose(state.torques[0], (0, -729.030636, 1503.975716), atol=1e-6)


def test_an_elastic_planar_stage_is_as_stiff_as_a_displacement_method_has_it():
    """A 3-RRR stage of aluminium boxes in space, over-constrained six times, and its drives alone
    with all else rigid.
    """
    metals = metal(70, 26)
    drive = {"drive": {"gearbox": {"stiffness": "50e3 N m/rad"}}}
    sections = [{"section": box(*size), "material": metals} for size in ((80, 50, 5), (60, 40, 4))]
    q = (-0.387773, 1.561341, 3.472764)
    whole = at(three_rrr(**drive, section=sections), q)
    printed = (3.050744e-6, 3.016675e-6, 3.753846e-5, 1.461129e-6, 2.058469e-6, 2.202004e-7)
    assert np.diag(whole.compliance[0]) == pytest.approx(printed, rel=4e-6)
    stiff = np.linalg.inv(at(three_rrr(**drive), q).compliance[0][np.ix_([2, 3, 4], [2, 3, 4])])
    printed = [32857.361, -14948.251, 3873.342, 894740.469, 179733.356, 630451.431]
    assert stiff[np.triu_indices(3)] == pytest.approx(printed, rel=2e-5)
