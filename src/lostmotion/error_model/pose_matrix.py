"""The pose matrix of an arm: how much each elementary error moves the tool at each pose, per unit
draw.
"""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.calibrated import mixtures
from lostmotion.error_model.closing import Closing, closed_in_some, mean_and_change
from lostmotion.error_model.columns import Draws, ToolScrews, column_of, grouped
from lostmotion.error_model.draws import Stream
from lostmotion.error_model.settled_columns import moved_tool
from lostmotion.laws.distributions import COMPARED
from lostmotion.mechanism.load_feedback import forget_carries
from lostmotion.mechanism.standing import bytes_of, forget_states, standing_at
from lostmotion.mechanism.state import BLOCK, as_poses, blocks_of
from lostmotion.parts import forms_together
from lostmotion.parts.term import LOADS
from lostmotion.recent import Recent

if TYPE_CHECKING:
    from collections.abc import Hashable, Iterator, Mapping

    from numpy.typing import NDArray

    from lostmotion.error_model.calibrated import Mixture
    from lostmotion.error_model.columns import Column, Groups, Key
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.calibration import Correlations
    from lostmotion.mechanism.conditions import Conditions
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.mechanism.state import State
    from lostmotion.parts.term import Form, Threshold
    from lostmotion.spatial import Floats


@dataclass(frozen=True)
class PoseMatrix(ToolScrews):
    """The pose matrix of an arm, with a column for each term. Sums of squares use `merged`, whose
    columns have independent draws; samples use `summed`, which has a column for each draw.

    groups     indices of the columns of each error by its draws; the design columns are the group
               without a draw, and columns with correlated draws are one group
    place      (column,) index of the place in whose frame `local` is expressed
    scale      (column,) size of the term; columns of one form at one place are proportional to it
               at every pose
    local      (pose, 6, column) screw at the place, rad and m per unit draw
    closed     (row, pose) share of robots in which a load closes the play of each `Closing`
    state      state of the arm at the poses, about which its errors are linearised
    columns_of    computes the screws of the columns in other frames
    mixtures   independent draws of the groups with correlated ones
    correlations  the correlations of draws; None where all are independent
    last_motion   sign of each joint's last motion, one for all or (pose, joint)
    """

    infos: tuple[Column, ...]
    groups: Groups
    place: NDArray[np.int64]
    scale: Floats
    local: Floats
    closed: Floats
    state: State
    columns_of: Columns
    mixtures: Mapping[Key, Mixture] = field(default_factory=dict)
    correlations: Correlations | None = None
    last_motion: Floats = field(default_factory=functools.partial(np.zeros, ()))

    def stretch(self, first: int, last: int) -> PoseMatrix:
        """Return the matrix of the poses from number `first` to `last` - 1."""
        return self.rows(slice(first, last))

    def rows(self, rows: slice | NDArray[np.int64]) -> PoseMatrix:
        """Return the matrix of the poses in these rows."""
        return replace(
            self,
            tool=self.tool[rows],
            local=self.local[rows],
            closed=self.closed[:, rows],
            state=self.state.rows(rows),
            last_motion=last_motion_at(self.last_motion, rows),
        )

    def scaled(self, factors: Floats) -> PoseMatrix:
        """Return the matrix with every column scaled by its factor (column,)."""
        return replace(
            self, tool=self.tool * factors, scale=self.scale * factors, local=self.local * factors
        )

    @property
    def closed_in_some(self) -> NDArray[np.bool_]:
        """Return whether (row, pose) a load closes the play in some robots and not in others."""
        return closed_in_some(self.closed)

    @functools.cached_property
    def owners(self) -> tuple[str, ...]:
        """Return the names of the parts that have columns, in the order of the columns."""
        return tuple(dict.fromkeys(info.owner for info in self.infos))

    @functools.cached_property
    def summed(self) -> ToolScrews:
        """Return the matrix with one column per draw: the sum of the columns that have this draw.
        Draws of several columns may be correlated.
        """
        groups = grouped(self.infos) if self.mixtures else self.groups
        out = self.along_poses[:, [members[0] for members in groups.values()]]
        for column, (_, *others) in enumerate(groups.values()):
            for k in others:
                out[:, column] += self.along_poses[:, k]
        firsts = (self.infos[members[0]] for members in groups.values())
        return ToolScrews(
            tuple(Draws(info.robot, info.visit, info.closing) for info in firsts),
            out.transpose(2, 0, 1),
        )

    @functools.cached_property
    def merged(self) -> ToolScrews:
        """Return the matrix with one column per independent draw, those of correlated draws last:
        `summed`, where no draws are correlated.
        """
        if not self.mixtures:
            return self.summed
        infos, shifts = [*self.uncorrelated.infos], [self.uncorrelated.along_poses]
        for key, mixed in self.mixtures.items():
            first = self.infos[self.groups[key][0]]
            infos += [Draws(stream, first.visit, first.closing) for stream in mixed.streams]
            shifts.append(mixed.weights.T @ self.along_poses[:, self.groups[key]])
        return ToolScrews(tuple(infos), np.concatenate(shifts, axis=1).transpose(2, 0, 1))

    @functools.cached_property
    def uncorrelated(self) -> ToolScrews:
        """Return the columns of `summed` whose draws are independent of all others."""
        if self.correlations is None:
            return self.summed
        row = self.correlations.row
        kept = [k for k, info in enumerate(self.summed.infos) if info.robot_name not in row]
        return ToolScrews(tuple(self.summed.infos[k] for k in kept), self.summed.tool[:, :, kept])

    @functools.cached_property
    def products(self) -> dict[Key, Floats]:
        """Return for each group with correlated draws the products (column, column), m^2, of its
        displacements of the tool point, times the correlation of their draws, summed over the
        poses.

        They add to the mean square of the group; the share of a column in it is the sum of its row.
        """
        return {
            key: mixed.correlation * sum(x @ x.T for x in self.along_poses[3:, self.groups[key]])
            for key, mixed in self.mixtures.items()
        }

    def mean_squares(self, factors: Floats) -> Floats:
        """Return the mean square displacement of the tool point (pose,), m^2, with every column
        scaled by its factor (column,).
        """
        return np.asarray(self.scaled(factors).merged.squares.sum(axis=0))


def last_motion_at(last_motion: Floats, rows: slice | NDArray[np.int64]) -> Floats:
    """Return the signs of the joints' last motions at the poses in these rows, of one for all or of
    (pose, joint).
    """
    return last_motion[rows] if last_motion.ndim else last_motion


def screws(state: State, *, approach: float | Floats = 0.0) -> PoseMatrix:
    """Return the pose matrix of an arm in this state, to first order in the errors about it: about
    the loaded arm for a settled state, about the command for any other.

    In a settled state of a soft arm the deflections follow the loads that an error changes
    (`load_feedback`). For a stiff arm, and at the command, the loads are those of the state.

    approach  sign of the joints' last motion, 0 where it is drawn at every visit: one for all, or
              (pose, joint)

    Valid for small errors; `propagation.exact.check` reports what first order neglects.
    """
    return Columns(state.arm, approach).matrix(state)


def pose_matrix(arm: Arm, q: Floats, *, approach: float | Floats = 0.0) -> PoseMatrix:
    """Return the pose matrix of an arm where it stands under its loads at these poses: what every
    prediction of errors is made of.

    The last ones are kept, and nobody changes their arrays. Arguments as `state_of` and `screws`.
    Raises InputError where the arm cannot hold its load at a pose, with the joint.
    """
    values, sides = as_poses(arm, q), np.asarray(approach, dtype=float)
    return _RECENT.of(
        (id(arm), values.tobytes(), sides.tobytes(), sides.ndim),
        lambda: screws(standing_at(arm, values), approach=sides),
    )


def pose_matrices(
    arm: Arm, q: Floats, size: int = BLOCK, *, approach: float = 0.0
) -> Iterator[tuple[slice, PoseMatrix]]:
    """Yield the rows of q and the pose matrix there, for at most `size` poses at a time; arguments
    and errors as `pose_matrix`.
    """
    for here, values in blocks_of(as_poses(arm, q), size):
        yield here, pose_matrix(arm, values, approach=approach)


# Matrices of a study that several of its figures need, some thousand poses.
_RECENT: Final = Recent[PoseMatrix](
    192 << 20, lambda matrix: 4 * matrix.tool.nbytes + bytes_of(matrix.state)
)


def forget_matrices() -> None:
    """Keep no matrix and no state, in a run that visits each pose once."""
    _RECENT.clear()
    forget_carries()
    forget_states()


@dataclass(frozen=True)
class _Family:
    """Successive terms of one form at one place, whose screws are proportional to each other; or
    springs or harmonics of one motion.

    of       one of the terms
    form     writes the screws of all
    scales   (term,) sizes
    columns  the columns of all terms for each pair of side and part, and the row of `closed`, None
             where no friction decides
    """

    of: PlacedTerm
    form: Form | forms_together.Springs | forms_together.Harmonics
    scales: Floats
    columns: tuple[tuple[str | None, str, slice], ...]
    row: int | None


class Columns:
    """The columns of the pose matrix of an arm: what does not depend on the pose, computed once for
    many poses.

    infos  the draws of each column
    fixed  (column,) whether no load changes its screw
    jumps  (column,) whether a load moves it within a play
    """

    def __init__(self, arm: Arm, approach: float | Floats = 0.0) -> None:
        """Number the columns; approach as for `screws`."""
        self._last_motion = np.asarray(approach, dtype=float)
        sides, names = _sides(self._last_motion), [joint.name for joint in arm.driven]
        thresholds: dict[tuple[int, Threshold], int] = {}
        infos: list[Column] = []
        self._families: list[_Family] = []
        for (_, _, kind, sided), run in itertools.groupby(arm.terms, _kind):
            members = list(run)
            form = members[0].term.form
            kinds = list(
                itertools.product(
                    sides if sided else (None,),
                    ("whole",) if form.threshold is None else ("mean", "changed"),
                )
            )
            row = (
                None
                if form.threshold is None
                else thresholds.setdefault((members[0].place, form.threshold), len(thresholds))
            )
            first, last = len(infos), len(infos) + len(members) * len(kinds)
            columns = tuple(
                (side, part, slice(first + k, last, len(kinds)))
                for k, (side, part) in enumerate(kinds)
            )
            writes = (
                form
                if isinstance(kind, int)
                else forms_together.together([of.term.form for of in members])
            )
            self._families.append(
                _Family(
                    members[0], writes, np.array([of.term.scale for of in members]), columns, row
                )
            )
            for of in members:
                closing = None
                if row is not None and form.threshold is not None:
                    closing = Closing(
                        Stream(f"{of.owner}.{form.threshold.stream}", COMPARED), row, form.above
                    )
                infos += [column_of(of, side, names, closing, part) for side, part in kinds]
        self.infos = tuple(infos)
        self._groups = grouped(infos, arm.correlations)
        self._correlations = arm.correlations
        self._mixtures = mixtures(infos, self._groups, arm.correlations)
        self._rows = len(thresholds)
        self._place = np.array([info.of.place for info in infos], dtype=int)
        self._scale = np.array([info.of.term.scale for info in infos])
        forms = [info.of.term.form for info in infos]
        loaded = [not LOADS.isdisjoint(form.reads) for form in forms]
        self.fixed = ~np.array(loaded, dtype=bool)
        self.jumps = np.array([form.jumps for form in forms], dtype=bool)
        # without the sides of a known approach, which are no part of the equilibrium
        settles = [each.of.term.level == "design" and each.closing is None for each in infos]
        self._settles = np.array(settles, dtype=bool)

    def matrix(self, state: State) -> PoseMatrix:
        """Return the pose matrix in a state of the arm.

        In a settled state the design columns add up to the exact displacement of the tool from its
        command, and the other columns of a soft arm change the loads (`settled_columns`).
        """
        closed = np.empty((self._rows, len(state)))
        local = self.local(state, state.conditions(), self._last_motion, closed)
        tool = moved_tool(state, self._place, local, self._settles)
        return PoseMatrix(
            self.infos,
            tool.transpose(2, 0, 1),
            self._groups,
            self._place,
            self._scale,
            local.transpose(2, 0, 1),
            closed,
            state,
            self,
            self._mixtures,
            self._correlations,
            self._last_motion,
        )

    def local(
        self,
        state: State,
        conditions: Conditions,
        last_motion: Floats,
        closed: Floats,
        *,
        loads_alone: bool = False,
        play: bool = True,
    ) -> Floats:
        """Return the screw of each column at its place per unit draw (6, column, pose), rad and m,
        and write the shares of closed plays (row, pose) to `closed`.

        last_motion  sign of each joint's last motion, one for all or (pose, joint)
        loads_alone  compute only columns that depend on loads, with the shares in `closed` as they
                     are; the others (`fixed`) have no value
        play         compute also those that a load moves within a play (`jumps`)
        """
        done: set[int] = set(range(self._rows)) if loads_alone else set()
        # The pose is the innermost axis in memory, since every loop below runs along it.
        local = np.empty((6, len(self.infos), len(state)))
        for family in self._families:
            of, row = family.of, family.row
            form = of.term.form
            if (loads_alone and LOADS.isdisjoint(form.reads)) or (form.jumps and not play):
                continue
            condition = conditions(of)
            if row is not None and form.threshold is not None and row not in done:
                closed[row] = form.threshold.share(condition)
                done.add(row)
            mean, changed = (
                (None, None) if row is None else mean_and_change(closed[row], above=form.above)
            )
            for side, part, columns in family.columns:
                screw = local[:, columns]
                family.form.write(condition, family.scales, screw)
                if side is not None and of.joint is not None:
                    screw *= _side_factor(
                        last_motion if last_motion.ndim == 0 else last_motion[:, of.joint],
                        known=side == "known",
                    )
                factor = {"whole": None, "mean": mean, "changed": changed}[part]
                if factor is not None:
                    screw *= factor
        return local


def _kind(of: PlacedTerm) -> tuple[int, int | None, Hashable, bool]:
    """Return what the terms of one `_Family` have in common."""
    form = of.term.form
    return of.place, of.joint, forms_together.kind(form) or id(form), of.term.sided


def _sides(last_motion: Floats) -> tuple[str, ...]:
    """Return the columns that a sided term has: "known" for poses whose last motion is known,
    "drawn" for poses where the side is drawn.
    """
    return (
        *(("known",) if (last_motion != 0).any() else ()),
        *(("drawn",) if (last_motion == 0).any() else ()),
    )


def _side_factor(last_motion: Floats, *, known: bool) -> Floats:
    """Return the factor on a sided screw. After a positive motion the factor is -1: the output
    trails the motor, and rests behind it.
    """
    return -last_motion if known else (last_motion == 0).astype(float)
