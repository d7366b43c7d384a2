"""Load sharing of a cycloidal stage: the force on each lobe, and the wind-up of the output.

A rigid disc rests on unilateral contacts (Hertz by a named law, in series with the bending of pin or lobe), on the eccentric's bearing and on the
output. The unknowns are the disc's displacement along x and across y the line of centres and its rotation. For one disc; divide the torque first
(half each for two, 0.55 is customary). Frictionless, quasi-static. The model omits the bodies of disc and ring: finite elements of a solid steel
stage put 31 % (Palmgren) to 42 % (Johnson) of its wind-up there, while the lobes' shares hardly change. `cycloid.bodies` adds them: together with
Johnson's law the sum is 0.5 to 1.1 % above those finite elements.

Source: M. Lehmann, TU München 1976; S. Malhotra, M. Parameswaran, Analysis of a cycloid speed reducer, Mech. Mach. Theory 18 (1983) 491 (closed
forms); equilibrium with gaps as in J. Blanche, D. Yang, J. Mech. Transm. Autom. Des. 111 (1989) 337, with the bearing's compliance added.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.contact import LEAST_LOGARITHM, johnson_scale, palmgren_factor, peak_pressure
from lostmotion.laws.cycloid.geometry import arms, contact_radius, normals, pin_angles, pitch_distance

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.laws.cycloid.geometry import Stage
    from lostmotion.spatial import Floats

FlankLaw = Literal["johnson", "palmgren", "linear"]


@dataclass(frozen=True, slots=True)
class Flanks:
    """Stiffness of the contacts between disc and pins or lobes. Raises ValueError for impossible values.

    `width` m of the contact; `modulus` E* Pa; `law` of the approach; `bending` m/N of pin or lobe in series, zero for rigid ones; `stiffness` N/m of
    each contact, for the "linear" law alone.
    """

    width: float
    modulus: float
    law: FlankLaw = "johnson"
    bending: float = 0.0
    stiffness: float = math.inf

    def __post_init__(self) -> None:
        """Refuse impossible values."""
        if self.law not in get_args(FlankLaw):
            raise ValueError(f"no law of approach is called {self.law!r}: choose 'johnson', 'palmgren' or 'linear'")
        if not (self.width > 0 and self.modulus > 0 and self.bending >= 0 and self.stiffness > 0):
            raise ValueError("the contact's width, modulus and stiffness must be positive, its bending zero or more")
        if (self.law == "linear") != math.isfinite(self.stiffness):
            raise ValueError("the 'linear' law needs a finite contact stiffness, and no other law uses one")


@dataclass(frozen=True, slots=True)
class Supports:
    """Supports of the disc besides the flanks; infinite means rigid. Arrays (draw,) hold one value per simulated gearbox.

    `bearing` N/m of the eccentric (bearing, shaft and seats in series) in any direction across its axis; `output` N m/rad between disc and output;
    `pin_circle` m, the radius Rw of output pins in holes, which push the disc along the line of centres by 4 T/(pi Rw); infinite for crankshafts that
    carry the output themselves.
    """

    bearing: float | Floats = math.inf
    output: float | Floats = math.inf
    pin_circle: float = math.inf


@dataclass(frozen=True, slots=True)
class Friction:
    """Coulomb friction coefficients by place; zero for none.

    `flank` between disc and lobes: 0.05 to 0.1 sliding in grease, about 0.005 with rollers; `bearing` of the eccentric, about 0.002 at its
    `bearing_radius` (m) with rolling elements; `output` of pins on `pin_circle` (m) in their holes, with sleeves times bore over sleeve radius.
    """

    flank: float
    bearing: float = 0.0
    bearing_radius: float = 0.0
    output: float = 0.0
    pin_circle: float = math.inf


@dataclass(frozen=True, slots=True)
class LoadSharing:
    """The equilibrium of one disc, with axes (torque, crank, draw, ...). Cases that did not converge are NaN, with `converged` False."""

    rotation: Floats  # rad, of the output from its unloaded position without gaps, in the torque's direction
    forces: Floats  # (..., N) N, per pin or lobe
    pressures: Floats  # (..., N) Pa, the peak in each contact
    bearing_force: Floats  # N, on the eccentric
    stiffness: Floats  # N m/rad, the slope of the torque over the rotation; 0 where the disc is free in its play
    lobes: Floats  # number of loaded lobes
    residual: Floats  # of the equilibrium: largest unbalanced force, as a share of T/(e z)
    converged: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]

    def checked(self) -> LoadSharing:
        """Return this result, or raise DidNotConvergeError with the number of unsolved cases and the first of them."""
        missed = np.argwhere(~self.converged)
        if len(missed):
            raise DidNotConvergeError(
                f"{len(missed)} of {self.converged.size} loaded contacts found no equilibrium, the first at (torque, crank, draw) = "
                f"{tuple(map(int, missed[0]))}: the load is beyond the law of approach, or a value is not a number"
            )
        return self


def load_sharing(
    stage: Stage,
    flanks: Flanks,
    torque: Floats | Sequence[float],
    crank: Floats | Sequence[float] = (0.0,),
    gaps: Floats | float = 0.0,
    supports: Supports | None = None,
    *,
    threads: int = 1,
) -> LoadSharing:
    """Return the forces on the lobes of one disc and its rotation, at torques (torque,) x crank angles (crank,) x simulated gearboxes.

    `torque` N m about the planet's centre, of either sign; at zero torque the disc lies anywhere in its play, and the rotation is reported as 0.
    `gaps` m along the normals, negative for interference, any shape that broadcasts to (crank, draw, N). The residual is below 1e-9 of the torque,
    usually 1e-12; otherwise the case is marked as not converged. That includes a torque below a millionth of the interference forces, where rounding
    hides it. The result is identical for any `threads`. Raises ValueError for shapes that do not fit, values that are not finite, or supports that
    are not positive.
    """
    from lostmotion.laws.cycloid import contact_kernel as kernel

    supports = supports or Supports()
    torque, crank = np.atleast_1d(np.asarray(torque, dtype=float)), np.atleast_1d(np.asarray(crank, dtype=float))
    gap = np.asarray(gaps, dtype=float)
    gap = np.ascontiguousarray(np.broadcast_to(gap, (*gap.shape[:-1], stage.pins))[(None,) * (3 - max(gap.ndim, 1))])
    bearing, output = (np.atleast_1d(np.asarray(value, dtype=float)) for value in (supports.bearing, supports.output))
    draws = np.broadcast_shapes(gap.shape[1:2], bearing.shape, output.shape)[0]
    if gap.shape[0] not in {1, len(crank)}:
        raise ValueError(f"gaps are given for {gap.shape[0]} crank angles, but there are {len(crank)}")
    if not (np.isfinite(torque).all() and np.isfinite(crank).all() and np.isfinite(gap).all()):
        raise ValueError("torques, crank angles and gaps must be finite numbers")
    if not ((bearing > 0).all() and (output > 0).all() and supports.pin_circle > 0):
        raise ValueError("the bearing's and the output's stiffness and the pin circle must be positive; infinite means rigid")
    theta = pin_angles(stage, crank)
    radius = contact_radius(stage, theta)
    law, soft, scale, largest = _coefficients(flanks, radius)
    shape = (len(torque), len(crank), draws)
    cases = math.prod(shape)
    out, forces = np.empty((cases, kernel.COLUMNS)), np.empty((cases, stage.pins))
    across = np.ascontiguousarray(normals(stage, theta)[..., 0])
    arm = arms(stage, theta) / stage.planet_pitch_radius
    thrust = 0.0 if math.isinf(supports.pin_circle) else 4 / (math.pi * supports.pin_circle)
    stiffness = np.ascontiguousarray(np.broadcast_to(bearing, draws))
    given = (law, stage.planet_pitch_radius, thrust, torque, across, arm, soft, scale, largest, gap, stiffness, out, forces)
    edges = np.linspace(0, cases, min(4 * threads, cases) + 1 if threads > 1 else 2).astype(int)
    if threads > 1:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(lambda ends: kernel.solve_cases(ends[0], ends[1], *given), pairwise(edges)))
    else:
        kernel.solve_cases(0, cases, *given)
    return _named(flanks, radius, torque, output, out.reshape(*shape, -1), forces.reshape(*shape, -1))


def _coefficients(flanks: Flanks, radius: Floats) -> tuple[int, Floats, Floats, Floats]:
    """Return what the kernel needs of a law: its number, two coefficients and the largest valid force, per contact."""
    from lostmotion.laws.cycloid import contact_kernel as kernel

    one = np.ones_like(radius)
    if flanks.law == "linear":
        return kernel.LINEAR, (1 / flanks.stiffness + flanks.bending) * one, 0 * one, np.inf * one
    if flanks.law == "palmgren":
        return kernel.POWER, palmgren_factor(flanks.width) * one, flanks.bending * one, np.inf * one
    soft = 1 / (math.pi * flanks.modulus * flanks.width)
    scale = np.log(johnson_scale(flanks.width, radius, flanks.modulus))
    # delta = soft F (ln B - ln F) + bending F: bending only shifts ln B
    return kernel.LOGARITHMIC, soft * one, scale + flanks.bending / soft, np.exp(scale - LEAST_LOGARITHM)


def _named(flanks: Flanks, radius: Floats, torque: Floats, output: Floats, out: Floats, forces: Floats) -> LoadSharing:
    from lostmotion.laws.cycloid import contact_kernel as kernel

    converged = np.isfinite(out[..., kernel.ROTATION])
    with np.errstate(invalid="ignore"):
        pressures = peak_pressure(forces / flanks.width, radius[None, :, None, :], flanks.modulus)
    return LoadSharing(
        rotation=out[..., kernel.ROTATION] + torque[:, None, None] / output,
        forces=forces,
        pressures=pressures,
        bearing_force=out[..., kernel.BEARING],
        stiffness=1 / (out[..., kernel.SOFTNESS] + 1 / output),
        lobes=np.where(converged, out[..., kernel.LOADED], np.nan),
        residual=out[..., kernel.RESIDUAL],
        converged=converged,
    )


def output_pin_stiffness(pin: float, radius: float, count: int) -> float:
    """Return the stiffness k_w Rw^2 n_w/4 (N m/rad) of n_w output pins of k_w (N/m) on the radius Rw (m), half of them loaded."""
    return pin * radius**2 * count / 4


def friction_torque(stage: Stage, crank: Floats | Sequence[float], answer: LoadSharing, friction: Friction) -> Floats:
    """Return one disc's Coulomb friction at the output (N m, (torque, crank, draw)), at the crank angles of `answer`.

    Per radian of the output each flank slides by its distance from the pitch point, R D - Rr (planet pins: + Rr). The eccentric's bearing turns and
    the output pins slide at the crank's speed, N times (planet pins: z times) the output's: F_b r_b N and F_pin e N. The loads are those without
    friction: an estimate, valid while the friction stays below about a fifth of the torque. Seals, grease and preloaded bearings add to it.
    """
    theta = pin_angles(stage, np.atleast_1d(np.asarray(crank, dtype=float)))
    reach = stage.ring_radius * pitch_distance(stage, theta) + (1 if stage.twin else -1) * stage.pin_radius
    meshes = friction.flank * (answer.forces * np.abs(reach)[None, :, None, :]).sum(axis=-1)
    moment = np.abs((answer.forces * arms(stage, theta)[None, :, None, :]).sum(axis=-1))
    pins = friction.output * stage.ring_pitch_radius * 4 / math.pi * moment / friction.pin_circle
    faster = stage.ring_pitch_radius / stage.eccentricity
    return np.asarray(meshes + pins + friction.bearing * friction.bearing_radius * faster * answer.bearing_force)


def efficiency(torque: Floats, friction: Floats) -> Floats:
    """Return the efficiency T/(T + M_f) for torques and friction torques of shapes that broadcast; 0 without load."""
    load = np.abs(np.asarray(torque, dtype=float))
    return np.asarray(np.where(load > 0, load, 0.0) / np.where(load + friction > 0, load + friction, 1.0))
