"""Selection of an arm's parts for a target on the tool: a search at a few poses, verified by a full
study.

The search uses mean and covariance of the error under the normal assumption, at fewer poses than
the study; for a target on RP, of what differs between visits. The ratio of the two results corrects
the target of the next search, until the upper end of the study's confidence interval is within the
target.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.sizing.sizing import SizedArmResult
from lostmotion.error_model.arrival import rp_key
from lostmotion.error_model.visit_scatter import refuse_without_scatter
from lostmotion.io.arm_writer import NewParts
from lostmotion.mechanism.standing import refuse_any_fall
from lostmotion.propagation.error_samples import Drawn
from lostmotion.propagation.figures import HEADLINE, figures_of
from lostmotion.propagation.montecarlo.common_random_numbers import thinned
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.propagation.montecarlo.sensitivity import halving
from lostmotion.sizing.error_cache import TARGETS, TargetOf, approach_for
from lostmotion.sizing.evaluation import Choice, Constraints
from lostmotion.sizing.search import Search

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from lostmotion.error_model.budget import Halving
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.sizing.candidates import Objective, PartCandidate, Slot

# Other targets of the trade-off, relative to the stated one.
SCALES: Final = (0.8, 0.9, 1.1, 1.25, 1.5)
# Most full studies; relative rise of the search's target that is worth another search; margin on
# it.
_MOST_STUDIES: Final = 5
_LEAST_RISE: Final = 1.003
_MARGIN: Final = 0.999
# The smaller study of other targets, and of one part replaced by the cheapest.
_POSES: Final = 1024
_ROBOTS: Final = 512
_VISITS: Final = 4


@dataclass(frozen=True, slots=True)
class StudySize:
    """Size of a study: robots, visits of each robot to each pose, seed and threads; `of`: the
    figure that it computes.
    """

    robots: int = 1000
    visits: int = 30
    seed: int = 1
    threads: int = 1
    of: TargetOf = "error"


@dataclass(frozen=True, slots=True)
class SelectedPart:
    """One selected part, the cheapest candidate, its saving, and the 95 % error (m) with it in
    place of the selected one.
    """

    slot: Slot
    selected: PartCandidate
    cheapest: PartCandidate
    saving: float
    error_with_cheapest: Estimate | None


@dataclass(frozen=True, slots=True)
class TargetPoint:
    """One point of the trade-off: target (m), cost, mass (kg), price and 95 % error (m) of its
    selection, and whether the search met it.
    """

    target: float
    cost: float
    mass: float
    price: float
    error: Estimate
    meets_target: bool


@dataclass(frozen=True, repr=False)
class Selection(SizedArmResult):
    """An arm with parts selected for a target on the tool.

    arm, sized        as stated, and with the selected parts
    poses             of the study; `search_poses` is the number of those of the search
    error_before, error  `quantity` (95 % error, or RP), m, by full studies of both arms
    search_targets    targets of the successive searches, m, corrected by the ratio of study to
                      search
    is_feasible       all constraints are met
    proven            all cheaper selections were evaluated; else no exchange of one or two parts is
                      cheaper
    combinations      number of possible selections; `evaluated` of them, and pairs with `predicted`
                      error only
    trade_off         other targets, strict to loose, and the stated one (the reached one where it
                      is out of reach)
    halving           effect of halving the errors of each part of the sized arm
    torques           N m by joint with a gearbox to select, largest holding torque over the poses
                      of the search and the corners of the joint ranges
    small_study       (poses, robots, visits) of the studies in `trade_off` and `parts`
    """

    arm: Arm
    sized: Arm
    target: float
    objective: Objective
    constraints: Constraints
    poses: Poses
    search_poses: int
    study_size: StudySize
    parts: tuple[SelectedPart, ...]
    mass: float
    price: float
    mass_before: float
    price_before: float
    error_before: Estimate
    error: Estimate
    search_targets: tuple[float, ...]
    is_feasible: bool
    proven: bool
    combinations: int
    evaluated: int
    predicted: int
    trade_off: tuple[TargetPoint, ...]
    halving: Halving
    torques: dict[str, float]
    small_study: tuple[int, int, int]
    notes: tuple[str, ...] = ()
    source: Path | None = None
    sidecar: Path | None = None

    page = "page.selection"

    @property
    def quantity(self) -> str:
        """Return the name of the figure that the target limits."""
        return TARGETS[self.study_size.of]

    @property
    def meets_target(self) -> bool:
        """Return whether all constraints are met and the upper end of the error's interval is
        within the target.
        """
        return self.is_feasible and self.error.high <= self.target

    @property
    def is_met(self) -> bool:
        """Return whether the target is met."""
        return self.meets_target

    @property
    def new_parts(self) -> list[NewParts]:
        """Return every part that is not the present one."""
        keys = {"link": "section", "gearbox": "gearbox", "bearing": "clearance"}
        return [
            NewParts(
                name,
                **{
                    keys[each.slot.kind]: each.selected.part
                    if each.slot.kind == "link"
                    else each.selected.file_value
                },
            )
            for each in self.parts
            if each.selected.part is not None
            for name in each.slot.joints
        ]


def select_parts(  # noqa: PLR0913 - the numbers of a search
    arm: Arm,
    slots: tuple[Slot, ...],
    objective: Objective,
    target: float,
    search_poses: Poses,
    poses: Poses,
    *,
    constraints: Constraints | None = None,
    study_size: StudySize | None = None,
    of: TargetOf = "error",
    progress: Callable[[str, int, int], None] | None = None,
) -> Selection:
    """Return the selection of least cost whose 95 % error, or RP, over all `poses`, robots and
    visits meets the target (m).

    `search_poses` are those of the search. Where no selection meets the target, the most accurate
    one is returned (`Selection.meets_target`). Raises InputError where the selection falls at a
    pose, with the joint, or has no RP.
    """
    size, constraints = replace(study_size or StudySize(), of=of), constraints or Constraints()
    stages = _MOST_STUDIES + len(SCALES) + 3
    stage = 0

    def report() -> None:
        if progress is not None:
            progress(f"selecting parts, {len(evaluator.evaluations)} evaluated", stage, stages)

    search = Search(arm, slots, objective, search_poses.q, constraints, report, of)
    evaluator = search.evaluator
    choice, proven, inner, tried = search.solve(target, pairs=False), False, target, list[float]()
    refuse_any_fall(evaluator.arm_with(choice), poses.q)  # before any study
    if of != "error":
        refuse_without_scatter(evaluator.arm_with(choice), poses.q, approach_for(of))
    best: tuple[Choice, bool, Estimate] | None = None
    for turn in range(1, _MOST_STUDIES):
        error = _studied(evaluator.arm_with(choice), poses, size)
        met = search.evaluate(choice).violation <= 0 and error.high <= target
        if tried and (
            best is None
            or (met, -search.evaluate(choice).cost if met else -error.high)
            > _rank(search, best, target)
        ):
            best = choice, proven, error
        # Corrected by the ratio of the search's error to that of the study.
        corrected = (
            _MARGIN
            * target
            * (
                search.error(choice) / error.high
                if error.high > 0 and search.error(choice) > 0
                else 1.0
            )
        )
        if tried and (
            (met and corrected <= inner * _LEAST_RISE) or not search.meets(choice, inner)
        ):
            break
        stage = turn
        inner = corrected if not tried or met else min(corrected, _MARGIN * inner)
        tried.append(inner)
        choice, proven = _selected(search, inner, () if best is None else (best[0],))
    if best is None:
        raise ValueError("no selection was studied")
    choice, proven, error = best
    stage = _MOST_STUDIES + 1
    before = _studied(arm, poses, size)
    # Where the target is out of reach, the trade-off is around the error that was reached.
    middle = (
        target if search.evaluate(choice).violation <= 0 and error.high <= target else error.high
    )
    trade_off = _trade_off(
        search,
        choice,
        middle,
        middle * search.error(choice) / error.high if error.high > 0 else middle,
        poses,
        size,
        report,
    )
    stage = stages - 1
    report()
    parts = tuple(_selected_part(search, choice, k, poses, size) for k in range(len(search.slots)))
    sized = evaluator.arm_with(choice)
    evaluation = search.evaluate(choice)
    some = thinned(poses, _POSES)
    return Selection(
        arm=arm,
        sized=sized,
        target=target,
        objective=objective,
        constraints=constraints,
        poses=poses,
        search_poses=len(search_poses),
        study_size=size,
        parts=parts,
        mass=evaluation.mass,
        price=evaluation.price,
        mass_before=sum(slot.present.mass for slot in slots),
        price_before=sum(slot.present.price for slot in slots),
        error_before=before,
        error=error,
        search_targets=tuple(tried),
        is_feasible=evaluation.violation <= 0,
        proven=proven,
        combinations=math.prod(len(slot.candidates) for slot in search.slots),
        evaluated=len(evaluator.evaluations),
        predicted=search.predicted,
        trade_off=trade_off,
        halving=halving(sized, poses, size.robots, size.visits, size.seed),
        torques={
            joint.name: float(torque)
            for joint, torque in zip(sized.driven, evaluator.torques(sized), strict=True)
            if any(joint.name in slot.joints and slot.kind == "gearbox" for slot in slots)
        },
        small_study=(len(some), min(size.robots, _ROBOTS), _few_visits(size)),
    )


def _rank(search: Search, best: tuple[Choice, bool, Estimate], target: float) -> tuple[bool, float]:
    """Return the rank of a selection: within the target the cheaper, else the more accurate."""
    met = search.evaluate(best[0]).violation <= 0 and best[2].high <= target
    return met, -search.evaluate(best[0]).cost if met else -best[2].high


def _selected(search: Search, inner: float, starts: tuple[Choice, ...]) -> tuple[Choice, bool]:
    choice = search.solve(inner, starts)
    if not search.meets(choice, inner):
        return choice, False
    return search.prove(inner, search.refine(inner, choice))


def _studied(arm: Arm, poses: Poses, size: StudySize) -> Estimate:
    """Return the 95 % error of an arm by a full study, or the RP of 95 % of robots."""
    approach = approach_for(size.of)
    sampled = run(
        arm,
        poses,
        size.robots,
        size.visits,
        size.seed,
        approach=approach,
        threads=size.threads,
        compared=0,
    )
    errors = Drawn.of(sampled, approach=approach)
    key = HEADLINE if size.of == "error" else f"{rp_key(approach)}_p95"
    return figures_of(errors)[key].estimate(errors)


def _few_visits(size: StudySize) -> int:
    """Return the visits of a smaller study; RP of fewer ones would be another figure."""
    return min(size.visits, _VISITS) if size.of == "error" else size.visits


def _small_study(search: Search, choice: Choice, poses: Poses, size: StudySize) -> Estimate:
    """Return the 95 % error of a selection by a smaller study."""
    few = replace(size, robots=min(size.robots, _ROBOTS), visits=_few_visits(size))
    return _studied(search.evaluator.arm_with(choice), thinned(poses, _POSES), few)


def _trade_off(
    search: Search,
    choice: Choice,
    target: float,
    inner: float,
    poses: Poses,
    size: StudySize,
    report: Callable[[], None],
) -> tuple[TargetPoint, ...]:
    """Return the selections for other targets, searched from the neighbour's and the cheapest."""
    points: dict[float, Choice] = {1.0: choice}
    for scales in (
        [scale for scale in SCALES if scale > 1],
        [scale for scale in reversed(SCALES) if scale < 1],
    ):
        here = choice
        for scale in scales:
            report()
            within = [
                each
                for start in (here, search.cheapest())
                if search.meets(each := search.near(scale * inner, start), scale * inner)
            ]
            # Where both fail, the most accurate selection may still be within the target.
            here = (
                min(within, key=lambda each: search.evaluate(each).cost)
                if within
                else search.solve(scale * inner, (here,), pairs=False)
            )
            points[scale] = here
    out = []
    for scale, each in sorted(points.items()):
        evaluation = search.evaluate(each)
        met = evaluation.violation <= 0 and (scale == 1 or search.meets(each, scale * inner))
        error = _small_study(search, each, poses, size)
        out.append(
            TargetPoint(
                scale * target, evaluation.cost, evaluation.mass, evaluation.price, error, met
            )
        )
    return tuple(out)


def _selected_part(
    search: Search, choice: Choice, k: int, poses: Poses, size: StudySize
) -> SelectedPart:
    slot = search.slots[k]
    costs = np.array([search.evaluator.cost_of_part(each) for each in slot.candidates])
    least = int(costs.argmin())
    saving = float(costs[choice[k]] - costs[least])
    error = (
        _small_study(search, (*choice[:k], least, *choice[k + 1 :]), poses, size)
        if saving > 0
        else None
    )
    return SelectedPart(slot, slot.candidates[choice[k]], slot.candidates[least], saving, error)
