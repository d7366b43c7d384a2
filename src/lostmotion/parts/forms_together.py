"""Springs and harmonics along one motion, evaluated together: a drawn gearbox has dozens, and at
one pose each by itself costs more than its sum.

Every size has the same bits as by its own form.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lostmotion.parts.forms import Harmonic, Spring, write_along

if TYPE_CHECKING:
    from collections.abc import Hashable, Sequence

    from lostmotion.parts.forms import Curve
    from lostmotion.parts.term import Condition, Form
    from lostmotion.spatial import Floats


def kind(form: Form) -> Hashable:
    """Return what forms have in common that are evaluated together; None for a form that is
    evaluated by itself.
    """
    if isinstance(form, Harmonic):
        return (
            Harmonic,
            form.direction.tobytes(),
            form.turns,
            None if form.envelope is None else form.envelope.load.tobytes(),
        )
    if isinstance(form, Spring) and form.travel is None and not form.fed_forward:
        return Spring, form.direction.tobytes(), form.odd, form.curve.load.tobytes()
    return None


def together(forms: Sequence[Form]) -> Springs | Harmonics:
    """Return forms of the same `kind`, which is not None, as one."""
    springs = [form for form in forms if isinstance(form, Spring)]
    return (
        Springs(springs)
        if springs
        else Harmonics([form for form in forms if isinstance(form, Harmonic)])
    )


class Curves:
    """Several curves with knots at the same loads."""

    def __init__(self, curves: Sequence[Curve]) -> None:
        """Take the knots of the first one."""
        self._load, self._value = curves[0].load, np.array([curve.value for curve in curves])
        # beyond the last knot `_beyond` continues
        self._slope = np.append(
            np.diff(self._value) / np.diff(self._load), np.zeros((len(curves), 1)), axis=1
        )
        self._beyond = np.array([[curve.beyond] for curve in curves])

    def __call__(self, load: Floats) -> Floats:
        """Return the value of each curve (curve, pose) at loads (pose,) of zero or more."""
        known = np.maximum(load, self._load[0])
        knot = np.searchsorted(self._load, known, "right") - 1
        within = self._slope[:, knot] * (known - self._load[knot]) + self._value[:, knot]
        return np.asarray(within + np.maximum(load - self._load[-1], 0.0) * self._beyond)


class Springs:
    """Springs of one motion with knots at the same loads."""

    def __init__(self, forms: Sequence[Spring]) -> None:
        """Take forms of the same `kind`."""
        self._direction, self._odd = forms[0].direction, forms[0].odd
        self._curves = Curves([form.curve for form in forms])

    def write(self, at: Condition, scales: Floats, out: Floats) -> None:
        """Write the screw of each form times its scale (term,) into `out` (6, term, pose)."""
        load = at.along(self._direction)
        sizes = self._curves(np.abs(load))
        write_along(
            self._direction, (np.sign(load) * sizes if self._odd else sizes) * scales[:, None], out
        )


class Harmonics:
    """Harmonics of one angle, without envelopes or with envelopes that have knots at the same
    loads.
    """

    def __init__(self, forms: Sequence[Harmonic]) -> None:
        """Take forms of the same `kind`."""
        self._direction, self._turns = forms[0].direction, forms[0].turns
        self._order = np.array([[form.order] for form in forms])
        self._of_phase = [
            (way, np.array([form.phase == phase for form in forms]))
            for phase, way in (("sine", np.sin), ("cosine", np.cos))
        ]
        envelopes = [form.envelope for form in forms if form.envelope is not None]
        self._envelopes = Curves(envelopes) if envelopes else None

    def write(self, at: Condition, scales: Floats, out: Floats) -> None:
        """Write the screw of each form times its scale (term,) into `out` (6, term, pose)."""
        turned = at.angle if self._turns is None else at.angle * self._turns
        sizes = np.empty(out.shape[1:])
        for way, of in self._of_phase:
            sizes[of] = way(self._order[of] * turned)
        if self._envelopes is not None:
            sizes *= self._envelopes(np.abs(at.along(self._direction)))
        write_along(self._direction, sizes * scales[:, None], out)
