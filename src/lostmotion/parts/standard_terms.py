"""Term lists that several parts share: a stated limit, a harmonic of unknown phase, a spring, a play, and friction's loop."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from lostmotion.laws.distributions import Cosine, Normal, Sine, of_tolerance
from lostmotion.parts.forms import Harmonic, Spring
from lostmotion.parts.play import HeldPlay, Seat
from lostmotion.parts.term import LAST_MOTION, Draw, Parameter, Term
from lostmotion.spatial import across

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.laws.distributions import Law
    from lostmotion.parts.forms import Curve
    from lostmotion.parts.term import Form, Motion
    from lostmotion.spatial import Floats
    from lostmotion.units import Toleranced

# A harmonic of unknown phase: its sine is drawn with the cosine of the phase, its cosine with the sine.
PHASES: Final[dict[Literal["sine", "cosine"], Law]] = {"sine": Cosine(), "cosine": Sine()}
# The kind of error that any reducer makes over a turn.
TRANSMISSION_ERROR: Final = "transmission error"


def parameter(key: str, value: object, unit: str, zones: int = 1) -> Parameter:
    """Return the parameter of this key, with its value where one number above zero states it."""
    stated = isinstance(value, int | float) and bool(value)
    return Parameter(key, float(value), unit, zones) if stated and isinstance(value, int | float) else Parameter(key)


def limit_terms(  # noqa: PLR0913 - what a term is made of
    name: str, form: Form, limit: float, law: Law, sized: Parameter, *, visit: bool = False, exponent: int = 1, cause: str = ""
) -> list[Term]:
    """Return the terms of a stated amount ±limit times a form, drawn per robot or per visit, after the mean of a law that has one."""
    draw, cause = Draw(name, law), cause or name
    out = [Term(f"mean {name}", f"mean {cause}", form, limit * law.mean, parameter=sized, exponent=exponent)] if law.mean else []
    robot, visited = (None, draw) if visit else (draw, None)
    return [*out, Term(name, cause, form, limit / law.stated, robot, visited, parameter=sized, exponent=exponent)]


def harmonic_terms(
    name: str, cause: str, direction: Floats, order: float, amplitude: float, sized: Parameter, turns: float | None = None
) -> list[Term]:
    """Return the two terms of amplitude x sin(order x angle + a phase drawn once per robot); amplitude in rad or m, `turns` as `Harmonic` has it."""
    size = amplitude / math.sqrt(2)
    return [
        Term(f"{name} {phase}", cause, Harmonic(direction, order, phase, turns), size, Draw(name, law), parameter=sized, effect=name)
        for phase, law in PHASES.items()
    ]


def spring_terms(direction: Floats, curve: Curve, scatter: float, sized: Parameter, name: str, stream: str) -> list[Term]:
    """Return the wind-up of a spring along a motion, and its ± share of scatter over samples under a name and a stream of its own."""
    form = Spring(direction, curve)
    out = [Term("wind-up", "wind-up", form, parameter=sized, exponent=-1)]
    if scatter:
        out.append(Term(name, name, form, scatter / Normal().bound, Draw(stream, Normal()), parameter=sized, exponent=-1))
    return out


class End(NamedTuple):
    """One way in which a play is free: the term's name, its unit twist (6,), what is drawn at every visit, and the effect it is a part of."""

    name: str
    direction: Floats
    draw: Draw
    effect: str = ""


def circle(name: str, stream: str, way: Floats, axis: Floats) -> list[End]:
    """Return the two ends of a round play across an axis (3,): a place on its circle that is drawn at every visit; `way` (3, 6) as `Seat` has it."""
    return [
        End(f"{name} position {k}", (direction @ way) / math.sqrt(2), Draw(stream, law), f"{name} position")
        for k, (direction, law) in enumerate(zip(across(axis), PHASES.values(), strict=True), 1)
    ]


def free_terms(cause: str, seat: Seat, ends: Sequence[End], half: float, spread: float, robot: Draw, sized: Parameter) -> list[Term]:
    """Return the terms of a play as far as the load leaves it free: `half` its half width, `spread` how much that differs per draw `robot`."""
    out = []
    for end in ends:
        form, effect = HeldPlay(seat, "free", end.direction), end.effect or end.name
        out.append(Term(end.name, cause, form, half, None, end.draw, sized, effect=effect))
        if spread:
            out.append(Term(f"free {end.name} amount", cause, form, spread, robot, end.draw, sized, effect=effect))
    return out


def play_terms(name: str, stated: Toleranced, seat: Seat, ends: Sequence[End], amount: str, sized: Parameter, *, cause: str = "") -> list[Term]:
    """Return the terms of a play of scattered size: held by the load, and free between its ends.

    amount   the stream of how much play a robot has: a play of size h (1 + k x) is one term of scale h and one of scale h k, drawn with x
    """
    held, law = HeldPlay(seat, "held"), of_tolerance(stated.law)
    cause = cause or name
    half, spread, robot = stated.nominal / 2, stated.tolerance / law.bound / 2, Draw(amount, law)
    out = [Term(f"{name} side held by load", cause, held, half, parameter=sized)]
    if spread:
        out.append(Term(f"{name} amount", cause, held, spread, robot, parameter=sized))
    return [*out, *free_terms(cause, seat, ends, half, spread, robot, sized)]


def backlash_terms(motion: Motion, stated: Toleranced, friction: Toleranced) -> list[Term]:
    """Return the terms of free play along a motion, held on one side by a load above `friction`, or else by the last motion."""
    if not stated.nominal:
        return []
    seat, ends = Seat(motion.twist[None], friction), [End("backlash", motion.twist, LAST_MOTION)]
    return play_terms("backlash", stated, seat, ends, "amount", parameter("play", stated.nominal, motion.unit))


def loop_term(form: Form, half: float, sized: Parameter) -> Term:
    """Return the term of friction's loop, of half its width: `half` x the form. Its side is that of the last motion."""
    return Term("hysteresis", "hysteresis", form, half, visit=LAST_MOTION, parameter=sized)
