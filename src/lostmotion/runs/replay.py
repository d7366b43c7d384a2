"""An extreme of a run, recomputed from its pose and its draws, term by term."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.provenance import states
from lostmotion.errors import refuse_argument
from lostmotion.propagation import exact
from lostmotion.runs.blocks import COLUMNS, compute, design_of, matrix_of
from lostmotion.runs.job import made_with
from lostmotion.runs.summary import Worst, with_pose, worst_of

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Self

    from lostmotion.error_model.provenance import States
    from lostmotion.runs.store import Store
    from lostmotion.spatial import Floats

# Other processors and versions differ in the last bits; this is a thousand times more than they do.
_SAME: Final = 1e-9
_LARGEST: Final = COLUMNS.index("largest")


@dataclass(frozen=True, slots=True)
class DrawnParameters:
    """One term of a replayed error: its name, the part that owns it, its level, what was drawn (1
    for a design term), its shift (3,) m.

    `along` is how much of the error's length it makes, m: its projection on the whole, so that all
    add up to the length.
    """

    name: str
    owner: str
    level: str
    draw: float
    shift: Floats
    along: float


@dataclass(frozen=True)
class Replay:
    """One extreme, computed again.

    store     the run, and `arm` the name of its design's arm
    found     the extreme as the store holds it
    joints    (name, type) of the moving joints, for found.q
    tool      (4, 4) where the tool should be, base frame
    error     (3,) m by the sum over terms; exact (4, 4) where the tool ends up by exact composition
    kernel    m, the length as the block gives it when computed again: the same bits as stored, with
              the same versions on the same kind of processor
    others    versions that differ from those that made the store
    terms     the largest contribution first
    known     states of the kinds of error of its design
    fallen    designs that fall at some poses, which are excluded
    """

    store: Store
    arm: str
    found: Worst
    joints: tuple[tuple[str, str], ...]
    tool: Floats
    error: Floats
    exact: Floats
    kernel: float
    others: tuple[str, ...]
    terms: tuple[DrawnParameters, ...]
    known: States
    fallen: tuple[int, ...] = ()

    @property
    def length(self) -> float:
        """Return the length of the sum over terms, m."""
        return float(np.linalg.norm(self.error))

    @property
    def apart(self) -> float:
        """Return by how much of itself the length differs from the stored one."""
        return abs(self.length / self.found.error - 1) if self.found.error else self.length

    @property
    def reproduced(self) -> bool:
        """Return whether block and sum over terms give the stored length again, but for the last
        digits that other processors or versions change.
        """
        return (
            self.apart <= _SAME and abs(self.kernel - self.found.error) <= _SAME * self.found.error
        )

    @classmethod
    def largest(
        cls,
        store: Store,
        design: int | None = None,
        worst: int = 1,
        progress: Callable[[str, int, int], None] | None = None,
    ) -> list[Self]:
        """Return the largest errors of a run, recomputed term by term. Of one design or of all,
        each of a pose of its own, the largest first. Designs that fall at some poses have no
        figures, and are excluded.

        Raises InputError for a design out of range or one that falls, LostmotionError where blocks
        are missing or damaged.
        """
        order = store.order
        if design is not None and not 0 <= design < order.designs:
            raise refuse_argument("design", design, f"from 0 to {order.designs - 1}", design=0)
        looked_at = range(order.designs) if design is None else [design]
        found: list[Worst] = []
        fallen: list[int] = []
        for k, each in enumerate(looked_at):
            own = found
            for block in range(order.blocks):
                record = store.read(each, block)
                own = worst_of(own, order, each, block, record, worst)
                if record.falls and each not in fallen:
                    fallen.append(each)
                if progress is not None:
                    progress(
                        "looking for the largest",
                        k * order.blocks + block + 1,
                        len(looked_at) * order.blocks,
                    )
            found = found if each in fallen else own
        if not found and fallen:
            expected = "a design that stands at all of its poses"
            other = next((each for each in range(order.designs) if each not in fallen), 0)
            raise refuse_argument("design", fallen[0], expected, design=other)
        out = []
        for extreme in found:
            out.append(cls._of(store, with_pose(order, extreme), tuple(fallen)))
            if progress is not None:
                progress("replaying", len(out), len(found))
        return out

    @classmethod
    def _of(cls, store: Store, worst: Worst, fallen: tuple[int, ...] = ()) -> Self:
        order = store.order
        first, _ = order.span(worst.block)
        row = worst.pose - first
        matrix = matrix_of(order, worst.design, worst.block)
        draws = exact.draws_of(
            matrix, row, order.seed, worst.pose, np.array([worst.robot]), np.array([worst.visit])
        )
        shifts = matrix.tool[row, 3:] * draws[:, 0]
        error = shifts.sum(axis=1)
        size = float(np.linalg.norm(error))
        terms = []
        for k, info in enumerate(matrix.infos):
            shift = shifts[:, k]
            if info.mean_by is not None:
                # Its mean over robots, and what this robot's friction changes about it: there, or
                # not there.
                changed = draws[k, 0] * draws[k + 1, 0]
                if changed and (changed > 0) != info.mean_by.above:
                    continue
                shift = shift + shifts[:, k + 1]
            if info.closing is None and shift.any():
                terms.append(
                    DrawnParameters(
                        info.name,
                        info.owner,
                        info.level,
                        float(draws[k, 0]),
                        shift,
                        float(error @ shift) / size if size else 0.0,
                    )
                )
        theirs, mine = order.made_with, made_with()
        arm = design_of(order, worst.design).arm
        return cls(
            store,
            order.read(worst.design).name,
            worst,
            tuple((joint.name, joint.type) for joint in arm.driven),
            matrix.state.commanded[-1, row],
            error,
            exact.compose(matrix, np.array([row]), draws[None])[0, 0],
            float(compute(order, worst.design, worst.block).poses[row, _LARGEST]),
            tuple(
                f"{name} {theirs.get(name)} there, {mine[name]} here"
                for name in mine
                if theirs.get(name) != mine[name]
            ),
            tuple(sorted(terms, key=lambda term: -abs(term.along))),
            states(arm),
            fallen,
        )
