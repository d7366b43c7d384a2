"""The example closed chains: each figure is pinned, and each mechanism moves as closed forms and
perturbed constraint equations have it, which share neither tree nor Jacobian with the package.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import root

import lostmotion
from tests.examples import delta_rods
from tests.mechanism.closed_chains import at, moved

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        (
            "sensitivity of the tool of four closed chains (five-bar, delta printer, hexapod, "
            "palletiser) to drives, lengths and places of joints"
        ),
        (
            "differences of their constraint equations: circles, distances from ball to ball, "
            "Plücker rows ([examples](tour/examples.md))"
        ),
        "1e-8",
    ),
)

EXAMPLES = Path(__file__).parents[2] / "examples" / "closed-chains"
X, Y, Z, TURN_Z = np.eye(6)[[3, 4, 5, 2]]
PRINTED = 6e-7


def example(name):
    """Return an example arm."""
    return lostmotion.read(EXAMPLES / f"{name}.toml")


def slope(solve, size=1e-3):
    """Return the derivative of `solve` at zero by central differences with two steps
    (Richardson).
    """
    coarse, fine = ((solve(h) - solve(-h)) / (2 * h) for h in (size, size / 2))
    return (4 * fine - coarse) / 3


@pytest.mark.slow
@pytest.mark.few_counts
@pytest.mark.parametrize(
    ("file", "cycle", "either", "accuracy"),
    [
        ("five-bar", 4.70e-6, 40.5e-6, 0.1774e-3),
        ("delta-printer", 13.08e-6, 45.1e-6, 0.1506e-3),
        ("hexapod", 0.1315e-6, 2.246e-6, 13.24e-6),
        ("parallelogram-palletiser", 0.3037e-6, 0.2305e-3, 1.494e-3),
    ],
)
def test_an_example_has_its_pinned_figures(file, cycle, either, accuracy):
    """Mean RP in the ISO cycle and from any approach, and mean AP (m), of a small study at seed 1;
    none has servos or scatter of friction, so that RP in the cycle is a lower bound.
    """
    study = lostmotion.study(example(file), 64, robots=100, visits=10)
    figures = study.result()["figures"]["iso9283"]
    found = [figures[f"{key}_mean"]["value"] for key in ("rp_iso", "rp_any", "ap")]
    assert found == pytest.approx([cycle, either, accuracy], rel=0.01)
    assert "RP, ISO cycle at least" in dict(study.sheet.brief)["RP"]


def five_bar_tool(left, right, lengths=(0.25, 0.4, 0.25, 0.4), motor=(0.2, 0.0)):
    """Return the pin (2,) of a five-bar: the upper intersection of two circles about its elbows."""
    a, b, c, d = lengths
    one = a * np.array([np.cos(left), np.sin(left)])
    other = np.array(motor) + c * np.array([np.cos(right), np.sin(right)])
    between = other - one
    length = np.linalg.norm(between)
    along = (b**2 - d**2 + length**2) / (2 * length)
    across = np.array([-between[1], between[0]]) / length
    return one + along * between / length + np.sqrt(b**2 - along**2) * across


def test_the_five_bar_moves_as_two_circles_do():
    """Each drive, link and motor, at the pose of the reference case."""
    state, q = at(example("five-bar"), (2.2, 0.9)), np.array([2.2, 0.9])
    np.testing.assert_allclose(state.frames[-1, 0, :2, 3], five_bar_tool(*q), atol=1e-9)
    unit = np.eye(4)
    lengths = np.array([0.25, 0.4, 0.25, 0.4])
    for place, twist, solve in (
        ("left", TURN_Z, lambda h: five_bar_tool(q[0] + h, q[1])),
        ("right", TURN_Z, lambda h: five_bar_tool(q[0], q[1] + h)),
        ("left.tip", X, lambda h: five_bar_tool(*q, lengths + h * unit[0])),
        ("left-elbow.tip", X, lambda h: five_bar_tool(*q, lengths + h * unit[1])),
        ("right.tip", X, lambda h: five_bar_tool(*q, lengths + h * unit[2])),
        ("right-elbow.tip", X, lambda h: five_bar_tool(*q, lengths + h * unit[3])),
        ("right.seat", X, lambda h: five_bar_tool(*q, motor=(0.2 + h, 0.0))),
        ("right.seat", Y, lambda h: five_bar_tool(*q, motor=(0.2, h))),
    ):
        np.testing.assert_allclose(moved(state, place, *twist)[3:5], slope(solve), atol=1e-8)


def test_the_table_of_the_delta_printer_is_what_six_distances_have():
    """Line by line: height, slope, bowl, tilt and scale for each single error."""
    text = (EXAMPLES / "delta-printer.toml").read_text("utf-8")
    stated = [line.removeprefix("# ") for line in text.splitlines() if line.startswith("# |")]
    assert stated == delta_rods.table()


def test_the_delta_printer_moves_as_six_distances_have_it():
    """Carriages, towers and single rods, away from the centre of the bed."""
    x, y = 0.03, -0.02
    heights = delta_rods.heights_at(x, y)
    state = at(example("delta-printer"), heights)
    point = (x, y, delta_rods.HEIGHT)
    np.testing.assert_allclose(state.frames[-1, 0, :3, 3], point, atol=1e-9)
    first = delta_rods.FIRST
    for place, twist, cause in (
        ("A_carriage", Z, {"stops": first}),
        ("A_carriage.seat", X, {"radius": first}),
        ("A_carriage.seat", Y, {"side": first}),
        ("A_carriage.seat", np.eye(6)[1], {"lean": first}),
        ("A_carriage", TURN_Z, {"yaw": first}),
        ("A1_rod.tip", -Z, {"rods": np.eye(6)[0]}),
        ("B2_rod.tip", -Z, {"rods": np.eye(6)[3]}),
    ):

        def solve(h, cause=cause):
            scaled = {key: h * value for key, value in cause.items()}
            return delta_rods.hot_end(heights + scaled.pop("stops", 0.0), point, **scaled)

        expected = slope(solve)[[3, 4, 5, 0, 1, 2]]
        np.testing.assert_allclose(moved(state, place, *twist), expected, atol=2e-8)


def test_the_hexapod_moves_as_the_inverse_of_its_pluecker_rows():
    """Each leg's length and the joints of base and platform, at the pose of the reference case, and
    the forces that the legs hold.
    """
    about_x, centre = 0.1, np.array([0.02, 0.03, 0.5])
    c, s = np.cos(about_x), np.sin(about_x)
    turned = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    base, levers = (
        np.array(
            [
                [radius * np.cos(angle), radius * np.sin(angle), 0.0]
                for k in range(6)
                for angle in [np.radians(120 * (k // 2) + (spread if k % 2 else -spread))]
            ]
        )
        for radius, spread in ((0.4, 15), (0.25, 45))
    )
    levers = levers @ turned.T
    legs = centre + levers - base
    lengths = np.linalg.norm(legs, axis=1)
    along = legs / lengths[:, None]
    inverse = np.linalg.inv(np.hstack([np.cross(levers, along), along]))
    state = at(example("hexapod"), lengths - 0.5)
    np.testing.assert_allclose(state.frames[-1, 0, :3, 3], centre, atol=1e-9)
    for k in range(6):
        for place in (f"{k + 1}_cardan.tip", f"{k + 1}_slide", f"{k + 1}_slide.tip"):
            np.testing.assert_allclose(moved(state, place, *Z), inverse[:, k], atol=1e-8)
        for axis, direction in zip(np.eye(6)[3:], np.eye(3), strict=True):
            # a joint of the base that moves along its leg pushes as a longer leg does
            expected = inverse[:, k] * (along[k] @ direction)
            found = moved(state, f"{k + 1}_cardan.seat", *axis)
            np.testing.assert_allclose(found, expected, atol=1e-8)
    held = (61.415671, 45.135624, 45.539997, 58.042840, 32.497887, 35.796005)
    np.testing.assert_allclose(state.torques[0], held, atol=1e-6)


# Shoulder, upper arm, forearm, heel and crank, arms of the triangle, and where they point; rods.
LENGTHS = {"arm": 1.05, "elbow": 1.1, "heel": 0.35, "crank": 0.35, "rod": 1.05}
LENGTHS |= {"level-rod": 1.05, "level-rod-2": 1.1}
LUG, AT = 0.25, 2.3


def palletiser(arm=1.9, crank=2.9, longer=("", 0.0)):
    """Return the tool (r, z, level) of the palletiser in its plane, m and rad: three closures by
    Newton's method on distances between pins.
    """
    of = {
        name: length + (longer[1] if name == longer[0] else 0.0) for name, length in LENGTHS.items()
    }

    def ray(length, angle):
        return length * np.array([np.cos(angle), np.sin(angle)])

    def pins(angles):
        forearm, triangle, wrist = angles
        elbow = np.array([0.35, 0.8]) + ray(of["arm"], arm)
        return elbow, elbow + ray(of["elbow"], forearm), forearm, triangle, wrist

    def misfit(angles):
        elbow, wrist, forearm, triangle, level = pins(angles)
        shoulder = np.array([0.35, 0.8])
        heel = elbow - ray(of["heel"], forearm)
        ends = (
            (shoulder + ray(of["crank"], crank), heel, of["rod"]),
            (shoulder + ray(LUG, AT), elbow + ray(LUG, AT + triangle), of["level-rod"]),
            (
                elbow + ray(LUG, np.pi / 2 + triangle),
                wrist + ray(LUG, np.pi / 2 + level),
                of["level-rod-2"],
            ),
        )
        return [np.linalg.norm(b - a) - length for a, b, length in ends]

    found = root(misfit, [crank - np.pi, 0.0, 0.0], tol=1e-14)
    assert np.abs(found.fun).max() < 1e-12
    _, wrist, *_, level = pins(found.x)
    turned = np.array([[np.cos(level), -np.sin(level)], [np.sin(level), np.cos(level)]])
    return np.append(wrist + turned @ [0.2, -0.25], level)


def test_the_palletiser_moves_and_carries_as_distances_between_its_pins_have_it():
    """Both drives and seven lengths, at the pose of the reference case; its drives hold the loads
    that virtual work has.
    """
    state = at(example("parallelogram-palletiser"), (0.3, 1.9, 2.9))
    np.testing.assert_allclose(
        state.frames[-1, 0, :3, 3], (1.221493, 0.377852, 1.280441), atol=PRINTED
    )
    out, across = np.array([np.cos(0.3), np.sin(0.3), 0]), np.array([np.sin(0.3), -np.cos(0.3), 0])
    raised = -np.eye(6)[1]
    for place, twist, solve in (
        ("arm", raised, lambda h: palletiser(arm=1.9 + h)),
        ("crank", raised, lambda h: palletiser(crank=2.9 + h)),
        ("arm.tip", X, lambda h: palletiser(longer=("arm", h))),
        ("elbow.tip", X, lambda h: palletiser(longer=("elbow", h))),
        ("rod.tip", X, lambda h: palletiser(longer=("rod", h))),
        ("crank.tip", X, lambda h: palletiser(longer=("crank", h))),
        ("heel.tip", -X, lambda h: palletiser(longer=("heel", h))),
        ("level-rod.tip", X, lambda h: palletiser(longer=("level-rod", h))),
        ("level-rod-2.tip", X, lambda h: palletiser(longer=("level-rod-2", h))),
    ):
        twisted = moved(state, place, *twist)
        found = np.array([out @ twisted[3:], twisted[5], across @ twisted[:3]])
        np.testing.assert_allclose(found, slope(solve), atol=1e-8)
    np.testing.assert_allclose(state.torques[0], (0, -729.030636, 1503.975716), atol=1e-5)
