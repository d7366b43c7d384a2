"""Arms made at random from a seed: every kind of part, joint and base mount, so that a rule can be
checked over the whole package at once.
"""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import lostmotion
from lostmotion import Arm
from lostmotion.units import Toleranced

STEEL = {"young": 210e9, "poisson": 0.3, "density": 7850.0}

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

EXAMPLES = Path(__file__).parents[2] / "examples"
_ARCMIN = np.pi / 180 / 60
_TABLE = ((-1.0, 0.0), (0.2, 0.5), (1.0, 1.0))
BEARINGS: tuple[dict[str, Any], ...] = (
    {
        "kind": "ball pair",
        "bore": 0.045,
        "outside_diameter": 0.085,
        "balls": 9,
        "ball_diameter": 0.0127,
        "pitch_diameter": 0.065,
        "span": 0.06,
    },
    {
        "kind": "roller pair",
        "bore": 0.06,
        "outside_diameter": 0.11,
        "rollers": 14,
        "roller_diameter": 0.014,
        "roller_length": 0.014,
        "pitch_diameter": 0.0855,
        "span": 0.08,
    },
    {
        "kind": "crossed roller bearing",
        "bore": 0.11,
        "outside_diameter": 0.15,
        "rollers": 48,
        "roller_diameter": 0.008,
        "roller_length": 0.006,
        "pitch_diameter": 0.13,
    },
)


def example_arms() -> list[Arm]:
    """Return the arms of the example files."""
    return [
        lostmotion.read(EXAMPLES / name)
        for name in ("z-arm.toml", "ur5e.urdf", "arm-from-drawings.toml", "paper/z-arm-lumped.toml")
    ]


def random_arms(count: int) -> list[Arm]:
    """Return the arms of the first so many seeds."""
    return [random_arm(seed) for seed in range(count)]


def random_poses(arm: Arm, count: int, seed: int = 1) -> Floats:
    """Return joint values (pose, joint) within the limits, rad or m; every joint stands at zero in
    the first pose.
    """
    share = np.random.default_rng(seed).uniform(size=(count, len(arm.moving)))
    out = arm.limits[:, 0] + share * np.diff(arm.limits, axis=1)[:, 0]
    out[0] = 0.0
    return out


def random_arm(seed: int) -> Arm:
    """Return the arm of a seed: three to seven joints, at least one of them moving, on some base,
    under some payload.
    """
    rng = np.random.default_rng(seed)
    made = _Maker(rng)
    count = int(rng.integers(3, 8))
    kinds = [
        "revolute",
        *rng.choice(["revolute", "revolute", "revolute", "prismatic", "fixed"], count - 1),
    ]
    base, joints = made.base(), [made.joint(f"J{k}", str(kind)) for k, kind in enumerate(kinds)]
    _guideways(np.random.default_rng([seed, 2]), joints)
    return Arm(
        name=f"random arm {seed}",
        base=base,
        joints=joints,
        environment=_surroundings(np.random.default_rng([seed, 1]), joints),
        payload={
            "mass": made.some(5.0),
            "centre_of_mass": made.vector(0.05),
            "force": made.vector(30.0) if made.often(0.3) else (0, 0, 0),
            "moment": made.vector(2.0) if made.often(0.3) else (0, 0, 0),
        },
        tool={"frame": {"xyz": made.vector(0.1), "rpy": made.vector(1.0)}, "mass": made.some(0.5)},
    )


def _surroundings(rng: np.random.Generator, joints: list[dict[str, Any]]) -> dict[str, Any]:
    """Return an environment for every other seed on average, and add to its links and bearings what
    expands and what is heated from one side.
    """
    if rng.uniform() < 0.5:
        return {}
    for joint in joints:
        link = joint["link"]
        if rng.uniform() < 0.7:
            link["expansion"] = float(rng.uniform(-1e-6, 50e-6))
        if (
            link.get("section", {}).get("kind") in ("tube", "box", "tapered")
            and rng.uniform() < 0.5
        ):
            link["material"] = {**link["material"], "expansion": 12e-6}
            link["temperature_difference"] = Toleranced(*rng.uniform(0, 6, 2).tolist())
        if "bore" in (joint.get("bearing") or {}):
            joint["bearing"] |= {
                "housing_interference": 2e-5,
                "housing_expansion": float(rng.uniform(10e-6, 30e-6)),
            }
    temperature = Toleranced(
        float(rng.uniform(273, 310)),
        float(rng.uniform(0, 10)),
        str(rng.choice(["normal", "uniform"])),
    )
    return {"temperature": temperature, "temperature_varies": str(rng.choice(["robot", "visit"]))}


def _guideways(rng: np.random.Generator, joints: list[dict[str, Any]]) -> None:
    """Add error motions to the sliding joints, by draws of their own so that all else stays as it
    is.
    """
    for joint in joints:
        if joint["type"] == "prismatic":
            names = ("pitch", "yaw", "roll")
            joint["guideway"] = {
                "straightness": tuple(rng.uniform(0, 5e-5, 2).tolist()),
                **{name: float(rng.uniform(0, 3e-4)) for name in names},
            }


@functools.cache
def _drawn_gearboxes() -> tuple[Any, ...]:
    arm = lostmotion.read(EXAMPLES / "arm-from-drawings.toml")
    return tuple(dict.fromkeys(joint.gearbox for joint in arm.moving))


class _Maker:
    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.turns = True

    def often(self, share: float) -> bool:
        return bool(self.rng.uniform() < share)

    def size(self, typical: float) -> float:
        return float(typical * self.rng.uniform(0.3, 2.0))

    def some(self, typical: float) -> float:
        return self.size(typical) if self.often(0.7) else 0.0

    def maybe(self, typical: float) -> float | None:
        return self.size(typical) if self.often(0.7) else None

    def vector(self, typical: float) -> tuple[float, float, float]:
        return tuple((typical * self.rng.uniform(-1, 1, 3)).tolist())

    def pick(self, *choices: Any) -> Any:
        return choices[int(self.rng.integers(len(choices)))]

    def toleranced(
        self, typical: float, laws: tuple[Any, ...] = ("normal", "uniform")
    ) -> Toleranced:
        nominal = self.size(typical)
        return Toleranced(
            nominal,
            nominal * float(self.rng.uniform(0.1, 0.9)) if self.often(0.7) else 0.0,
            self.pick(*laws),
        )

    def stated(self, **fields: Any) -> dict[str, Any]:
        return {name: value for name, value in fields.items() if value is not None}

    def axis(self) -> Any:
        return self.pick("x", "y", "z", "-x", "-y", "-z", self.vector(1.0))

    def base(self) -> dict[str, Any]:
        mount = self.pick(
            {},
            {"angular_stiffness": tuple(self.size(1e6) for _ in range(3))},
            {
                "linear_stiffness": tuple(self.size(1e8) for _ in range(3)),
                "angular_stiffness": tuple(self.size(1e6) for _ in range(3)),
            },
            {"compliance": {"matrix": np.diag([1e-6] * 3 + [1e-8] * 3).tolist(), "scatter": 0.1}},
            {"tracks": {"length": 0.6, "width": 0.1, "gauge": 0.5, "bedding": 5e7, "scatter": 0.2}},
        )
        tilt = {
            name: Toleranced(
                float(self.rng.uniform(-0.1, 0.1)),
                self.size(0.01),
                self.pick("normal", "uniform", "normal without limits", _TABLE),
            )
            for name in ("roll", "pitch")
            if self.often(0.5)
        }
        return {
            "xyz": self.vector(0.2),
            "rpy": self.vector(0.5),
            "tilt_varies": self.pick("robot", "visit"),
            **tilt,
            **mount,
        }

    def joint(self, name: str, kind: str) -> dict[str, Any]:
        self.turns = kind == "revolute"
        out: dict[str, Any] = {
            "name": name,
            "type": kind,
            "origin": {"xyz": self.vector(0.1), "rpy": self.vector(1.0)},
            "mounting": {"tilt": self.some(5e-4), "offset": self.some(2e-5)}
            if self.often(0.5)
            else None,
            "mass": self.maybe(3.0),
            "centre_of_mass": self.vector(0.05),
            "link": self.link(),
        }
        if kind != "fixed":
            limits = (-self.size(1.5), self.size(1.5)) if self.turns else (0.0, self.size(0.3))
            out |= {
                "axis": self.axis(),
                "limits": limits,
                "gearbox": self.gearbox(),
                "bearing": self.bearing(),
            }
            out |= {"encoder": self.encoder(out["gearbox"]), "lumped": self.lumped()}
            self.scatter(out)
        return self.stated(**out)

    def gearbox(self) -> Any:
        if self.often(0.15):
            return None
        if self.turns and self.often(0.15):
            return self.pick(*_drawn_gearboxes())
        angle, stiffness, torque = (2e-4, 4e4, 50.0) if self.turns else (2e-5, 1e8, 500.0)
        out = self.stated(
            rated_torque=self.maybe(torque),
            hysteresis=self.maybe(angle),
            friction_torque=self.some(0.05 * torque) if self.often(0.5) else None,
            mass=self.maybe(1.0),
            stiffness_scatter=float(self.rng.uniform(0, 0.2)),
            backlash=self.toleranced(angle) if self.often(0.7) else None,
        )
        if self.often(0.8):
            zones = self.rng.integers(1, 4) if self.turns else 1
            out["stiffness"] = [self.size(stiffness) for _ in range(zones)]
            out["zone_torques"] = [0.2 * torque * (k + 1) for k in range(zones - 1)]
        if "rated_torque" in out and "stiffness" in out and "backlash" not in out:
            out["lost_motion"] = 100 * angle
        if not self.turns:
            return out | {"lead": 0.01, "ratio": 2.0, "transmission_error": self.size(angle)}
        waves = self.pick(
            self.size(angle),
            [
                {"amplitude": self.size(angle), "cycles": 2.0},
                {"amplitude": self.size(angle), "cycles": 117.5},
            ],
            None,
        )
        kind = self.pick(
            {"kind": "catalogue", "ratio": 100.0},
            {
                "kind": "planetary",
                "sun_teeth": 20,
                "ring_teeth": 70,
                "sun_error": self.some(angle),
                "planet_error": self.some(angle),
                "mesh_error": 1e-5,
            },
            {
                "kind": "wolfrom",
                "sun_teeth": 18,
                "planet_teeth": 36,
                "fixed_ring_teeth": 90,
                "output_planet_teeth": 33,
                "output_ring_teeth": 87,
                "first_mesh_error": self.some(angle),
                "second_mesh_error": self.some(angle),
            },
            {
                "kind": "strain wave",
                "flexspline_teeth": 200,
                "circular_spline_teeth": 202,
                "wave_generator_error": self.some(angle),
            },
            {
                "kind": "worm",
                "wheel_teeth": 60,
                "worm_error": self.some(angle),
                "wheel_error": self.some(angle),
                "mesh_error": self.some(angle),
            },
        )
        return {**out, **kind, **self.stated(transmission_error=waves)}

    def scatter(self, joint: dict[str, Any]) -> None:
        """Add what scatters from visit to visit, from a generator of its own: everything else is
        drawn as without it.
        """
        rng = self.rng.spawn(1)[0]
        share, gearbox, encoder = (
            float(rng.uniform(0, 0.5)),
            joint["gearbox"],
            joint["encoder"] or {},
        )
        if isinstance(gearbox, dict) and "hysteresis" in gearbox:
            gearbox["hysteresis_scatter"] = share
        if rng.uniform() < 0.5 and "dead_band" not in encoder:
            joint["servo"] = {"dead_band": share * (1e-3 if self.turns else 1e-4)}

    def bearing(self) -> dict[str, Any] | None:
        turning = self.turns
        closing = self.stated(closing_force=self.pick(None, 0.0, self.size(3.0)))
        runout = (
            {"radial_runout": self.some(1e-5), "axial_runout": self.some(1e-5)} if turning else {}
        )
        rolling = {
            "kind": "rolling",
            "clearance": self.toleranced(3e-5),
            "span": self.size(0.06),
            "radial_stiffness": self.maybe(1e8),
            **closing,
        }
        if turning:
            rolling |= {"axial_play": self.toleranced(2e-5), "axial_stiffness": self.maybe(2e8)}
        crossed = {
            "kind": "crossed roller",
            "moment_stiffness": self.maybe(1e5),
            "radial_stiffness": self.maybe(1e8),
            "pitch_diameter": 0.1,
            **runout,
        }
        if turning:
            crossed |= {"axial_stiffness": self.maybe(1e8)}
        drawn = {**self.pick(*BEARINGS), **closing, **runout}
        drawn["clearance"] = Toleranced(
            self.pick(-5e-6, 1.5e-5, 2.5e-5), self.pick(0.0, 4e-6), self.pick("normal", "uniform")
        )
        chosen = (
            self.pick(None, rolling, rolling, crossed, drawn)
            if turning
            else self.pick(None, rolling, crossed)
        )
        return chosen if chosen is None else self.stated(**chosen)

    def encoder(self, gearbox: Any) -> dict[str, Any] | None:
        if self.often(0.3):
            return None
        size = 2e-4 if self.turns else 2e-5
        side = self.pick("motor", "motor", "output")
        out = self.stated(
            side=side,
            resolution=self.maybe(size),
            noise=self.maybe(size),
            noise_law=self.pick("normal", "uniform", "normal without limits", _TABLE),
            zero=self.maybe(size),
            dead_band=self.maybe(size) if side == "output" else None,
        )
        turns = self.turns or (side == "motor" and gearbox is not None)
        return out | ({"eccentricity": self.size(size)} if turns and self.often(0.6) else {})

    def lumped(self) -> dict[str, Any] | None:
        if self.often(0.7):
            return None
        law = self.pick(
            "normal",
            "uniform",
            "two-sided",
            "from zero to maximum",
            "normal without limits",
            _TABLE,
        )
        return {
            "angle": self.some(3e-4),
            "law": law,
            "offset": self.some(1e-5),
            "offset_along": ["x", "z"],
            "varies": self.pick("robot", "visit"),
        }

    def link(self) -> dict[str, Any]:
        length = Toleranced(self.size(0.3), self.some(5e-5), self.pick("normal", "uniform"))
        direction = self.pick("x", "y", "z", self.vector(1.0))
        soft = {**STEEL, "scatter": 0.1}
        light = {"young": 70e9, "poisson": 0.33, "density": 2700.0, "scatter": 0.05}
        tube, box = (
            {"kind": "tube", "outer": 0.08, "wall": 0.004},
            {"kind": "box", "width": 0.05, "height": 0.07, "wall": 0.004},
        )
        made = self.pick(
            {},
            {"rigid": True},
            {"section": tube, "material": soft},
            {
                "section": box,
                "material": light,
                "mass": self.some(2.0),
                "centre_of_mass": self.vector(0.1),
            },
            {
                "section": {
                    "kind": "composite",
                    "layers": [
                        {"section": tube, "material": soft},
                        {"section": {**tube, "outer": 0.072}, "material": light},
                    ],
                }
            },
            {
                "compliance": {
                    "matrix": np.diag([2e-6, 1e-6, 1e-6, 1e-9, 1e-8, 1e-8]).tolist(),
                    "scatter": 0.1,
                },
                "mass": 1.0,
            },
            {
                "measured": {
                    "force": 100.0,
                    "deflection": 2e-4,
                    "slope": 5e-4,
                    "torque": 20.0,
                    "twist": 1e-3,
                    "scatter": 0.1,
                },
                "mass": 1.5,
            },
            {
                "section": {
                    "kind": "tapered",
                    "stations": [
                        {"at": 0.0, "section": tube},
                        {"at": length.nominal, "section": {**tube, "outer": 0.06}},
                    ],
                },
                "material": STEEL,
            },
            {
                "section": {
                    "kind": "stepped",
                    "steps": [
                        {"length": length.nominal / 2, "section": tube, "material": soft},
                        {"length": length.nominal / 2, "section": box},
                    ],
                },
                "material": light,
            },
        )
        if self.often(0.3) and "section" not in made:
            return {
                **made,
                "tip": {"xyz": (0.1, 0.2, 0.05), "rpy": self.vector(1.0)},
                "length_tolerance": self.some(5e-5),
            }
        return {**made, "length": length, "direction": direction}
