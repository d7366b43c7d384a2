"""Lists of terms that several parts share: a stated tolerance, a harmonic of unknown phase, a
spring, a play, and a friction loop.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

import numpy as np

from lostmotion.laws.distributions import Cosine, Normal, Sine, of_tolerance
from lostmotion.parts.forms import Constant, Curve, Harmonic, Spring
from lostmotion.parts.play import HeldPlay, Seat
from lostmotion.parts.term import LAST_MOTION, Draw, Parameter, Term
from lostmotion.spatial import across

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.laws.distributions import Law
    from lostmotion.parts.term import Form, Motion
    from lostmotion.spatial import Floats
    from lostmotion.units import Toleranced

# sin(n q + phase) = sin(n q) cos(phase) + cos(n q) sin(phase): the sine is drawn with the cosine of
# the phase, and the cosine with its sine.
PHASES: Final[dict[Literal["sine", "cosine"], Law]] = {"sine": Cosine(), "cosine": Sine()}
# Owner of the draw of the arm's temperature.
ENVIRONMENT: Final = "environment"
# Cause of what the ± of the arm's temperature moves.
VARIATION: Final = "temperature variation"
# A factor equal to the joint's value, over more than any joint's range.
_PROPORTIONAL: Final = Curve(np.array([-1e3, 1e3]), np.array([-1e3, 1e3]))
# Cause of the periodic error of any reducer.
TRANSMISSION_ERROR: Final = "transmission error"


def parameter(key: str, value: object, unit: str, zones: int = 1) -> Parameter:
    """Return the parameter of this key; it has a value and a unit only where `value` is one number
    other than zero.
    """
    stated = isinstance(value, int | float) and bool(value)
    return (
        Parameter(key, float(value), unit, zones)
        if stated and isinstance(value, int | float)
        else Parameter(key)
    )


def limit_terms(  # noqa: PLR0913 - what a term is made of
    name: str,
    form: Form,
    limit: float,
    law: Law,
    sized: Parameter,
    *,
    visit: bool = False,
    exponent: int = 1,
    cause: str = "",
) -> list[Term]:
    """Return the terms of a tolerance ±limit times a form, drawn per robot, or with `visit` per
    visit.

    A distribution whose mean is not zero has a design term for the mean first.

    limit     tolerance in the unit of the form's screw
    sized     parameter that the terms are proportional to, to the power `exponent`
    cause     kind of error; default: `name`
    """
    draw, cause = Draw(name, law), cause or name
    out = (
        [
            Term(
                f"mean {name}",
                f"mean {cause}",
                form,
                limit * law.mean,
                parameter=sized,
                exponent=exponent,
            )
        ]
        if law.mean
        else []
    )
    robot, visited = (None, draw) if visit else (draw, None)
    return [
        *out,
        Term(
            name,
            cause,
            form,
            limit / law.stated,
            robot,
            visited,
            parameter=sized,
            exponent=exponent,
        ),
    ]


def varying(  # noqa: PLR0913 - what a term is made of
    name: str,
    form: Form,
    stated: Toleranced,
    motion: Motion,
    sized: Parameter,
    *,
    shared: str = "",
    per_kelvin: float = 1.0,
    cause: str = "",
) -> list[Term]:
    """Return the term of how far a temperature differs from its nominal value, from robot to robot
    or from visit to visit; none without a ±.

    shared      owner of the draw where all parts of the arm have one temperature
    per_kelvin  what the form's screw is multiplied by, per kelvin
    cause       kind of error; default: `name`
    """
    if not stated.tolerance:
        return []
    law = of_tolerance(stated.law)
    draw = Draw("temperature" if shared else name, law, shared)
    robot, visit = (None, draw) if motion.varies == "visit" else (draw, None)
    return [
        Term(
            name,
            cause or name,
            form,
            per_kelvin * stated.tolerance / law.stated,
            robot,
            visit,
            parameter=sized,
        )
    ]


def free_play_variation(
    seat: Seat, ends: Sequence[End], per_kelvin: float, motion: Motion, sized: Parameter
) -> list[Term]:
    """Return the terms of how much wider a play is at the temperature of a robot, where the load
    leaves it open; none for visits.

    A play at the temperature of a visit, with a side drawn at the same visit, would be a product of
    two draws per visit: it is neglected.

    per_kelvin  change of the half width of the play, rad or m per kelvin
    """
    stated = motion.rise
    if stated is None or not stated.tolerance or motion.varies == "visit":
        return []
    law = of_tolerance(stated.law)
    robot, size = Draw("temperature", law, ENVIRONMENT), per_kelvin * stated.tolerance / law.stated
    return [
        Term(
            f"free {end.name} {VARIATION}",
            VARIATION,
            HeldPlay(seat, "free", end.direction),
            size,
            robot,
            end.draw,
            sized,
        )
        for end in ends
    ]


def harmonic_terms(
    name: str,
    cause: str,
    direction: Floats,
    order: float,
    amplitude: float,
    sized: Parameter,
    turns: float | None = None,
) -> list[Term]:
    """Return the two terms of amplitude x sin(order x angle + phase), the phase drawn once per
    robot.

    direction  (6,) unit twist
    order      cycles per turn
    amplitude  rad or m
    turns      as in `Harmonic`
    """
    size = amplitude / math.sqrt(2)
    return [
        Term(
            f"{name} {phase}",
            cause,
            Harmonic(direction, order, phase, turns),
            size,
            Draw(name, law),
            parameter=sized,
            effect=name,
        )
        for phase, law in PHASES.items()
    ]


def proportional_terms(
    name: str, motion: Motion, limit: float, sized: Parameter, cause: str
) -> list[Term]:
    """Return the terms of an error along the motion that grows in proportion to the joint's value:
    ±limit per unit of it, drawn per robot.
    """
    return limit_terms(
        name, Constant(motion.twist, _PROPORTIONAL), limit, Normal(), sized, cause=cause
    )


def spring_terms(
    direction: Floats,
    curve: Curve,
    scatter: float,
    sized: Parameter,
    name: str,
    stream: str,
    travel: Curve | None = None,
) -> list[Term]:
    """Return the terms of the wind-up of a spring, and of its scatter over robots.

    direction     (6,) unit twist
    curve         wind-up over the load, rad or m
    scatter       tolerance of the wind-up as a share of it, three standard deviations; 0: no
                  scatter
    name, stream  name of the scatter's term and of its draw
    travel        factor over the joint's value, as in `Spring`
    """
    form = Spring(direction, curve, travel=travel)
    out = [Term("wind-up", "wind-up", form, parameter=sized, exponent=-1)]
    if scatter:
        out.append(
            Term(
                name,
                name,
                form,
                scatter / Normal().bound,
                Draw(stream, Normal()),
                parameter=sized,
                exponent=-1,
            )
        )
    return out


class End(NamedTuple):
    """One direction of a free play: the name of its term, its unit twist (6,), its draw at every
    visit, and the effect that it is a part of.
    """

    name: str
    direction: Floats
    draw: Draw
    effect: str = ""


def circle(name: str, stream: str, way: Floats, axis: Floats) -> list[End]:
    """Return the two directions of a round play across an axis (3,): a position on its circle,
    drawn at every visit. `way` (3, 6) as in `Seat`.
    """
    return [
        End(
            f"{name} position {k}",
            (direction @ way) / math.sqrt(2),
            Draw(stream, law),
            f"{name} position",
        )
        for k, (direction, law) in enumerate(zip(across(axis), PHASES.values(), strict=True), 1)
    ]


def free_terms(
    cause: str,
    seat: Seat,
    ends: Sequence[End],
    half: float,
    spread: float,
    robot: Draw,
    sized: Parameter,
) -> list[Term]:
    """Return the terms of a play where the load leaves it open.

    half    half width of the play, rad or m
    spread  change of the half width per unit of the draw `robot`; 0: no scatter
    """
    out = []
    for end in ends:
        form, effect = HeldPlay(seat, "free", end.direction), end.effect or end.name
        out.append(Term(end.name, cause, form, half, None, end.draw, sized, effect=effect))
        if spread:
            out.append(
                Term(
                    f"free {end.name} amount",
                    cause,
                    form,
                    spread,
                    robot,
                    end.draw,
                    sized,
                    effect=effect,
                )
            )
    return out


def play_terms(
    name: str,
    stated: Toleranced,
    seat: Seat,
    ends: Sequence[End],
    amount: str,
    sized: Parameter,
    *,
    cause: str = "",
) -> list[Term]:
    """Return the terms of a play whose size scatters over robots: closed by the load, and open
    between its ends.

    A play of size h (1 + k x), with the draw x per robot, is a term of scale h and a term of scale
    h k that is drawn with x.

    stated   full width of the play with its tolerance, rad or m
    amount   name of the stream of x
    cause    kind of error; default: `name`
    """
    held, law = HeldPlay(seat, "held"), of_tolerance(stated.law)
    cause = cause or name
    half, spread, robot = stated.nominal / 2, stated.tolerance / law.bound / 2, Draw(amount, law)
    out = [Term(f"{name} side held by load", cause, held, half, parameter=sized)]
    if spread:
        out.append(Term(f"{name} amount", cause, held, spread, robot, parameter=sized))
    return [*out, *free_terms(cause, seat, ends, half, spread, robot, sized)]


def backlash_terms(motion: Motion, stated: Toleranced, friction: Toleranced) -> list[Term]:
    """Return the terms of backlash along a motion. A load above `friction` determines its side;
    under a smaller load the last motion does.

    stated    full width of the backlash with its tolerance, rad or m
    friction  load that closes it with its tolerance, N m or N
    """
    if not stated.nominal:
        return []
    seat, ends = Seat(motion.twist[None], friction), [End("backlash", motion.twist, LAST_MOTION)]
    return play_terms(
        "backlash", stated, seat, ends, "amount", parameter("play", stated.nominal, motion.unit)
    )


def backlash_variation(motion: Motion, friction: Toleranced, per_kelvin: float) -> list[Term]:
    """Return the terms of a backlash that changes by `per_kelvin` (rad/K) within the ± of the arm's
    temperature; arguments as `backlash_terms`.
    """
    if motion.rise is None:
        return []
    seat, sized = Seat(motion.twist[None], friction), Parameter("thermal expansion")
    held = HeldPlay(seat, "held")
    out = varying(
        f"backlash {VARIATION}",
        held,
        motion.rise,
        motion,
        sized,
        shared=ENVIRONMENT,
        per_kelvin=per_kelvin / 2,
        cause=VARIATION,
    )
    return out + free_play_variation(
        seat, [End("backlash", motion.twist, LAST_MOTION)], per_kelvin / 2, motion, sized
    )


def loop_terms(form: Form, half: float, sized: Parameter, scatter: float = 0.0) -> list[Term]:
    """Return the terms of a friction loop: `half`, half of its width, times the form. The last
    motion determines its side.

    scatter  ± share by which the friction, and with it the width of the loop, differs from visit to
             visit: three standard deviations; 0: no scatter

    At a visit the output rests at half (1 + scatter x) s, with the sign s of the last motion and a
    draw x of a symmetric distribution. Then x s has the distribution of x whatever s is: it is
    independent of s, and a draw of its own is exact whether the side is known or not.
    """
    out = [Term("hysteresis", "hysteresis", form, half, visit=LAST_MOTION, parameter=sized)]
    if scatter:
        name, law = "hysteresis scatter", Normal()
        out.append(
            Term(
                name, name, form, half * scatter / law.bound, visit=Draw(name, law), parameter=sized
            )
        )
    return out
