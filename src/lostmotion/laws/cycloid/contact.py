"""Load sharing of a cycloidal stage: the force on each lobe, and the wind-up of the output.

A disc is supported by unilateral contacts (Hertz by a law of approach, in series with the bending
of pin or lobe), by the eccentric's bearing and by the output. The unknowns are the displacements of
the disc along the line of centres (x) and across it (y), and its rotation. The torque is that of
one disc: half of the total for two discs, customarily 0.55. Valid for quasi-static load without
friction. The bodies of disc and ring are rigid, or elastic by their compliance at the contacts
(`cycloid.bodies`). By finite elements of a solid steel stage rigid bodies neglect 31 % (Palmgren)
to 42 % (Johnson) of its wind-up.

Source: M. Lehmann, TU München 1976; S. Malhotra, M. Parameswaran, Analysis of a cycloid speed
reducer, Mech. Mach. Theory 18 (1983) 491 (closed forms); equilibrium with gaps as in J. Blanche, D.
Yang, J. Mech. Transm. Autom. Des. 111 (1989) 337, with the bearing's compliance added.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.contact import LEAST_LOGARITHM, johnson_scale, palmgren_factor, peak_pressure
from lostmotion.laws.cycloid.geometry import arms, contact_radius, normals, pin_angles

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.laws.cycloid.stage import Stage
    from lostmotion.spatial import Floats

FlankLaw = Literal["johnson", "palmgren", "linear"]
# Fewer cases than this take less time than a thread needs to start.
_LEAST_BLOCK: Final = 400


@dataclass(frozen=True, slots=True)
class Flanks:
    """Stiffness of the contacts between disc and pins or lobes.

    width      of the contact, m
    modulus    E*, Pa
    law        of the approach: "johnson", "palmgren" or "linear"
    bending    compliance of pin or lobe in series, m/N; zero if rigid
    stiffness  of each contact, N/m; for the "linear" law only
    branches   by how many times a second branch stiffens each contact (`cycloid.envelope`); bending
               remains

    Raises ValueError for impossible values.
    """

    width: float
    modulus: float
    law: FlankLaw = "johnson"
    bending: float = 0.0
    stiffness: float = math.inf
    branches: float = 1.0

    def __post_init__(self) -> None:
        """Refuse impossible values."""
        if self.law not in get_args(FlankLaw):
            raise ValueError(
                f"no law of approach is called {self.law!r}: choose 'johnson', 'palmgren' or "
                "'linear'"
            )
        if not (
            self.width > 0
            and self.modulus > 0
            and self.bending >= 0
            and self.stiffness > 0
            and self.branches > 0
        ):
            raise ValueError(
                "the contact's width, modulus, stiffness and branches must be positive, its "
                "bending zero or more"
            )
        if (self.law == "linear") != math.isfinite(self.stiffness):
            raise ValueError(
                "the 'linear' law needs a finite contact stiffness, and no other law uses one"
            )


@dataclass(frozen=True, slots=True)
class Supports:
    """Supports of the disc besides the flanks; infinite means rigid. Arrays (draw,) hold one value
    per simulated gearbox, arrays (torque, draw or 1) one per torque as well.

    bearing     stiffness of the eccentric (bearing, shaft and seats in series) in any direction
                across its axis, N/m
    output      stiffness between disc and output, N m/rad
    pin_circle  radius Rw of output pins in holes, m, which push the disc along the line of centres
                by 4 T/(pi Rw); infinite for crankshafts that carry the output
    """

    bearing: float | Floats = math.inf
    output: float | Floats = math.inf
    pin_circle: float = math.inf


@dataclass(frozen=True, slots=True)
class LoadSharing:
    """The equilibrium of one disc; the axes of arrays are (torque, crank, draw, ...). Cases that
    did not converge are NaN.
    """

    # rad, of the output from its unloaded position without gaps, in the direction of the torque
    rotation: Floats
    forces: Floats  # (..., N) N, per pin or lobe
    pressed: Floats | None  # (crank, N) as of `load_sharing`
    radius: Floats  # (crank, N) m, equivalent radius of each contact
    flanks: Flanks
    bearing_force: Floats  # N, on the eccentric
    # N m/rad, derivative of the torque by the rotation; 0 where the disc is free in its play
    stiffness: Floats
    lobes: Floats  # number of loaded lobes
    residual: Floats  # largest unbalanced force, as a share of T/(e z)
    converged: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]

    @property
    def pressures(self) -> Floats:
        """Return the peak pressure of each contact (..., N), Pa."""
        flanks = self.flanks
        with np.errstate(invalid="ignore"):
            carried = (
                self.forces if self.pressed is None else self.forces * self.pressed[None, :, None]
            )
            return peak_pressure(carried / flanks.width, self.radius[None, :, None], flanks.modulus)

    def checked(self) -> LoadSharing:
        """Return this result. Raises DidNotConvergeError with the number of cases that did not
        converge and the first of them.
        """
        missed = np.argwhere(~self.converged)
        if len(missed):
            raise DidNotConvergeError(
                f"no equilibrium found in {len(missed)} of {self.converged.size} cases, the "
                "first at (torque, crank, draw) = "
                f"{tuple(map(int, missed[0]))}: the load is beyond the law of approach, or a "
                "value is not a number"
            )
        return self


def load_sharing(  # noqa: PLR0913 - stage, load, and what is elastic
    stage: Stage,
    flanks: Flanks,
    torque: Floats | Sequence[float],
    crank: Floats | Sequence[float] = (0.0,),
    gaps: Floats | float = 0.0,
    supports: Supports | None = None,
    *,
    bodies: Floats | None = None,
    stiffening: Floats | None = None,
    pressed: Floats | None = None,
    places: np.ndarray | None = None,
    threads: int = 1,
) -> LoadSharing:
    """Return the forces on the lobes of one disc and its rotation, at all combinations of torques,
    crank angles and simulated gearboxes (draws).

    torque   (torque,) on one disc about the planet's centre, N m, of either sign; at zero torque
             the disc is free in its play, and the rotation is 0
    crank    (crank,) crank angles, rad
    gaps     along the normals, m, negative for interference; any shape that broadcasts to (crank,
             draw, N)
    bodies   (side, crank, N, N) displacement of the bodies along contact i per force on contact j,
             m/N (`bodies.flexibility`), under forward and backward torques, or one for both; None
             for rigid bodies
    stiffening  (crank, N) by how many times each contact is stiffer than by its law; default:
                `branches` of the flanks
    pressed  (crank, N) share of each force that counts for the pressure of its contact, because a
             second branch carries the rest; default: all of it
    places   (place,) numbers of crank angles, one or more times each: gaps and results then have
             places for an axis in place of crank angles; default: each crank angle once
    threads  number of threads, on which the result does not depend

    The residual is below 1e-9 of the torque, usually 1e-12; otherwise the case is marked as not
    converged. That includes a torque below a millionth of the interference forces, which is lost in
    rounding. Raises ValueError for shapes that do not match, values that are not finite, or
    supports that are not positive.
    """
    from lostmotion.compiled import read_only
    from lostmotion.laws.cycloid import contact_kernel as kernel
    from lostmotion.laws.cycloid import elastic_kernel

    supports = supports or Supports()
    torque, crank = (
        np.atleast_1d(np.asarray(torque, dtype=float)),
        np.atleast_1d(np.asarray(crank, dtype=float)),
    )
    gap = np.asarray(gaps, dtype=float)
    gap = np.ascontiguousarray(
        np.broadcast_to(gap, (*gap.shape[:-1], stage.pins))[(None,) * (3 - max(gap.ndim, 1))]
    )
    bearing, output = (
        np.atleast_2d(np.asarray(value, dtype=float))
        for value in (supports.bearing, supports.output)
    )
    at = np.arange(len(crank)) if places is None else np.asarray(places)
    draws = np.broadcast_shapes(gap.shape[1:2], bearing.shape[1:], output.shape[1:])[0]
    if gap.shape[0] not in {1, len(at)}:
        raise ValueError(f"gaps are given for {gap.shape[0]} crank angles, but there are {len(at)}")
    if not (np.isfinite(torque).all() and np.isfinite(crank).all() and np.isfinite(gap).all()):
        raise ValueError("torques, crank angles and gaps must be finite numbers")
    if not ((bearing > 0).all() and (output > 0).all() and supports.pin_circle > 0):
        raise ValueError(
            "the bearing's and the output's stiffness and the pin circle must be positive; "
            "infinite means rigid"
        )
    theta = pin_angles(stage, crank)
    radius = contact_radius(stage, theta)
    stiffer = np.full_like(radius, flanks.branches) if stiffening is None else stiffening
    law, soft, scale, largest = _coefficients(flanks, radius, stiffer)
    shape = (len(torque), len(at), draws)
    cases = math.prod(shape)
    out, forces = np.empty((cases, kernel.COLUMNS)), np.empty((cases, stage.pins))
    across = np.ascontiguousarray(normals(stage, theta)[..., 0])
    arm = arms(stage, theta) / stage.planet_pitch_radius
    thrust = 0.0 if math.isinf(supports.pin_circle) else 4 / (math.pi * supports.pin_circle)
    stiffness = np.ascontiguousarray(np.broadcast_to(bearing, (len(torque), draws)))
    flexible = () if bodies is None else (_checked(bodies, len(crank), stage.pins),)
    given = read_only(
        law,
        stage.planet_pitch_radius,
        thrust,
        torque,
        np.ascontiguousarray(at, dtype=np.int64),
        across,
        arm,
        soft,
        scale,
        largest,
        gap,
        stiffness,
        *flexible,
    )
    solved = elastic_kernel.solve_cases if flexible else kernel.solve_cases

    def solve(first: int, last: int) -> None:
        solved(first, last, *given, out, forces)

    blocks = min(4 * threads, cases // _LEAST_BLOCK) if threads > 1 else 0
    if blocks > 1:
        edges = np.linspace(0, cases, blocks + 1).astype(int)
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(lambda ends: solve(ends[0], ends[1]), pairwise(edges)))
    else:
        solve(0, cases)
    if places is not None:
        radius, pressed = radius[at], None if pressed is None else pressed[at]
    return _named(
        flanks, radius, pressed, torque, output, out.reshape(*shape, -1), forces.reshape(*shape, -1)
    )


def _checked(bodies: Floats, cranks: int, pins: int) -> Floats:
    """Return the compliance of the bodies (side, crank, N, N) for the kernel. Raises ValueError for
    another shape, or values that are not finite.
    """
    if (
        bodies.ndim != 4  # noqa: PLR2004
        or bodies.shape[0] not in {1, 2}
        or bodies.shape[1:] != (cranks, pins, pins)
    ):
        raise ValueError(
            f"the compliance of the bodies has the shape {bodies.shape} instead of (1 or 2, "
            f"{cranks}, {pins}, {pins})"
        )
    if not np.isfinite(bodies).all():
        raise ValueError("the compliance of the bodies must be finite numbers")
    return np.ascontiguousarray(np.broadcast_to(bodies, (2, *bodies.shape[1:])))


def _coefficients(
    flanks: Flanks, radius: Floats, stiffening: Floats
) -> tuple[int, Floats, Floats, Floats]:
    """Return the parameters of the law of approach for the kernel: its number, and two coefficients
    and the largest valid force of each contact.
    """
    from lostmotion.laws.cycloid import contact_kernel as kernel

    one = np.ones_like(radius)
    if flanks.law == "linear":
        return (
            kernel.LINEAR,
            1 / (stiffening * flanks.stiffness) + flanks.bending,
            0 * one,
            np.inf * one,
        )
    if flanks.law == "palmgren":
        return (
            kernel.POWER,
            palmgren_factor(flanks.width) / stiffening,
            flanks.bending * one,
            np.inf * one,
        )
    soft = 1 / (math.pi * flanks.modulus * flanks.width * stiffening)
    scale = np.log(johnson_scale(flanks.width, radius, flanks.modulus))
    # delta = soft F (ln B - ln F) + bending F: bending only shifts ln B
    return kernel.LOGARITHMIC, soft, scale + flanks.bending / soft, np.exp(scale - LEAST_LOGARITHM)


def _named(
    flanks: Flanks,
    radius: Floats,
    pressed: Floats | None,
    torque: Floats,
    output: Floats,
    out: Floats,
    forces: Floats,
) -> LoadSharing:
    """Return the result; `pressed` as for `load_sharing`."""
    from lostmotion.laws.cycloid import contact_kernel as kernel

    converged = np.isfinite(out[..., kernel.ROTATION])
    soft = output[:, None]
    return LoadSharing(
        rotation=out[..., kernel.ROTATION] + torque[:, None, None] / soft,
        forces=forces,
        pressed=pressed,
        radius=radius,
        flanks=flanks,
        bearing_force=out[..., kernel.BEARING],
        stiffness=1 / (out[..., kernel.SOFTNESS] + 1 / soft),
        lobes=np.where(converged, out[..., kernel.LOADED], np.nan),
        residual=out[..., kernel.RESIDUAL],
        converged=converged,
    )


def output_pin_stiffness(pin: float, radius: float, count: int) -> float:
    """Return the stiffness k_w Rw^2 n_w/4 (N m/rad) of n_w output pins of stiffness k_w (N/m) on
    the radius Rw (m), half of them loaded.
    """
    return pin * radius**2 * count / 4
