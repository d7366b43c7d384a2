"""A run of many poses, or a grid of designs: result, headline, cards and sheet."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.result import Result
from lostmotion.analyses.sweep.design_tables import (
    approach_text,
    as_length,
    design_cards,
    design_sections,
    falls_text,
    known_of,
)
from lostmotion.error_model.arrival import rp_name
from lostmotion.error_model.provenance import States, states
from lostmotion.error_model.trust import error_remarks
from lostmotion.reporting.first_order import failed, failure, unsure
from lostmotion.reporting.not_counted import NOT_COUNTED, without_mass
from lostmotion.reporting.provenance import (
    assumed_drives_sentences,
    assumed_value_sentences,
    at_least,
    bound,
    caveats,
    error_sentence,
    provenance_facts,
    provenance_sections,
    repeatability_sentence,
    upper_limit_sentences,
)
from lostmotion.reporting.sheet import Sheet, several
from lostmotion.reporting.warnings import overload_warnings
from lostmotion.runs.design_names import design_name

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import xarray

    from lostmotion.error_model.overload import Overload
    from lostmotion.mechanism.arm import Arm
    from lostmotion.reporting.figure_files import FigureKind
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.table_files import TableKind
    from lostmotion.runs.job import Order
    from lostmotion.runs.store import Store
    from lostmotion.runs.summary import Outcome

# Longer tables are shortened; result.json has every design.
_MOST_ROWS: Final = 60
_WORDS: Final = (
    (
        "design",
        "one combination of the swept values; all designs share poses and random draws.",
    ),
    (
        "95th percentile",
        (
            "of the position error over all poses, robots and visits; its interval counts robots "
            "and independent sets of poses."
        ),
    ),
    (
        "AP, RP",
        (
            "ISO 9283 pose accuracy and repeatability, predicted: 95th percentile over robots of "
            "each robot's mean over the poses."
        ),
    ),
    (
        "difference",
        (
            "of the 95th percentile from that of the first design, with common random numbers: "
            "more precise than the two intervals suggest."
        ),
    ),
    (
        "largest",
        (
            "the largest error of these samples; it grows with their number. `lostmotion replay` "
            "lists its terms."
        ),
    ),
)


@dataclass(frozen=True, repr=False)
class Sweep(Result):
    """A completed run: `outcomes` by design; `store` has every block."""

    arm: Arm
    store: Store
    outcomes: tuple[Outcome, ...]

    @property
    def states(self) -> States:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values of
        the first design.
        """
        return states(self.arm)

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        return _sheet(self.arm, self.store.order, self.outcomes)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.sweep.plots import sweep_plots

        return sweep_plots(self.store.order, self.outcomes)

    def report(
        self,
        out: str | Path | None = None,
        *,
        force: bool = False,
        figures: FigureKind | None = None,
        tables: TableKind | None = None,
    ) -> Path:
        """Write report.html and result.json beside the blocks, or into the folder `out`, and return
        the folder. Errors as `Result.report`.
        """
        from lostmotion.reporting.page.document import contents

        if out is not None:
            return super().report(out, force=force, figures=figures, tables=tables)
        plots = self.plots
        for name, content in {
            **contents(self.sheet, plots),
            **self.copies(plots, figures, tables),
        }.items():
            self.store.keep(name, content)
        return self.store.folder

    def arrays(self) -> xarray.Dataset:
        """Return the figures of every design over the keys swept."""
        from lostmotion.runs.arrays import dataset

        return dataset(self.store.order, self.outcomes)

    def __repr__(self) -> str:
        """Return what was run, in a line."""
        order = self.store.order
        return (
            f"<Sweep of '{self.arm.name}': {order.designs} designs x {order.poses} poses x "
            f"{order.robots} robots x {order.visits} visits>"
        )


def _sheet(arm: Arm, order: Order, outcomes: Sequence[Outcome]) -> Sheet:
    """Return the sheet of a run of one or many designs."""
    counted = (
        f"{several(order.poses, 'pose')} ({order.law}) x {several(order.robots, 'robot')} x "
        f"{several(order.visits, 'visit')}"
    )
    fallen = [each for each in outcomes if each.falls]
    failing = [
        each.design for each in outcomes if not each.falls and failure(each.check, each.p95.value)
    ]
    outcomes = [unsure(each) if each.design in failing else each for each in outcomes]
    ranked = sorted(
        (each for each in outcomes if not each.falls),
        key=lambda each: (each.design in failing, each.p95.value),
    )
    sound = ranked[: len(ranked) - len(failing)]
    wrong = failed(
        [outcomes[design] for design in failing],
        len(outcomes),
        lambda design: design_name(order.axes, design),
    )
    chosen = [each for each in outcomes if not each.falls]
    if len(ranked) > _MOST_ROWS:
        chosen = ranked[: _MOST_ROWS // 2] + ranked[-_MOST_ROWS // 2 :]
    known = states(arm)
    each = f"{several(len(outcomes), 'design')}, each of " if len(outcomes) > 1 else ""
    return Sheet(
        name=arm.name,
        subject="a sweep of designs" if len(outcomes) > 1 else "a large run",
        verdict=" ".join(
            [*_falls(order, fallen), *wrong, *([_verdict(order, sound)] if sound else [])]
        ),
        cards=tuple(design_cards(order, sound, ranked)),
        sections=(
            *design_sections(order, outcomes, chosen, counted),
            *provenance_sections(known),
        ),
        counts=each + counted,
        warnings=(*arm.warnings, *_overloaded(order, outcomes)),
        notes=(_not_counted(outcomes), *error_remarks(arm))
        if len(outcomes) > 1
        else error_remarks(arm),
        words=_WORDS,
        source=_source(order, counted),
        seed=order.seed,
        facts={
            **_facts(arm, order, outcomes),
            "not_counted": _not_counted(outcomes),
            **provenance_facts(known),
        },
    )


def _falls(order: Order, fallen: Sequence[Outcome]) -> list[str]:
    """Return the headline's sentence on the designs that fall at some poses, with the one that does
    most often.
    """
    if not fallen:
        return []
    worst = max(fallen, key=lambda each: each.falls.count if each.falls else 0)
    counted = f"{len(fallen)} of {several(order.designs, 'design')}"
    name = design_name(order.axes, worst.design)
    return [f"{counted} fall at some poses and have no figures: with {name}, {falls_text(worst)}."]


def _overloaded(order: Order, outcomes: Sequence[Outcome]) -> tuple[str, ...]:
    """Return a warning per overloaded drive, or for many designs the number of those in which it is
    overloaded.
    """
    if len(outcomes) == 1:
        return overload_warnings(outcomes[0].overloads)
    worst: dict[str, tuple[Overload, Outcome]] = {}
    counts: Counter[str] = Counter()
    for outcome in outcomes:
        for each in outcome.overloads:
            counts[each.joint] += 1
            if (
                each.joint not in worst
                or each.held / each.rated > worst[each.joint][0].held / worst[each.joint][0].rated
            ):
                worst[each.joint] = each, outcome
    return tuple(
        (
            f"in {several(counts[joint], 'design')} of {len(outcomes)}, the worst "
            f"{design_name(order.axes, outcome.design)}: {sentence}"
        )
        for joint, (each, outcome) in worst.items()
        for sentence in overload_warnings([each])
    )


def _verdict(order: Order, ranked: Sequence[Outcome]) -> str:
    best, worst = ranked[0], ranked[-1]
    other = [
        each
        for each in worst.limits
        if (each.joint, each.model, each.key)
        not in {(one.joint, one.model, one.key) for one in best.limits}
    ]
    of_best, of_worst = (known_of(each) for each in (best, worst))
    known = replace(
        of_best if of_best.lower_bound or not of_worst.lower_bound else of_worst,
        limits=(*best.limits, *other),
    )
    best_figure, worst_figure = (as_length(each, each.p95) for each in (best, worst))
    if len(ranked) == 1:
        repeats = (
            (
                " "
                f"{repeatability_sentence(rp_name(order.approach), str(as_length(best, best.rp)), known)}"  # noqa: E501
            )
            if best.rp is not None
            else ""
        )
        interval = best_figure.interval or ("" if best_figure.assumed else "no interval")
        within = f"{best_figure} ({interval})" if interval else str(best_figure)
        return " ".join(
            [
                error_sentence(within, known) + repeats,
                *upper_limit_sentences(known),
                *assumed_drives_sentences(known),
                *assumed_value_sentences(known),
            ]
        )
    text = (
        f"Of {several(len(ranked), 'design')} the smallest 95th percentile of the position "
        f"error is {at_least(best_figure, of_best)}, "
        f"with {design_name(order.axes, best.design)}. "
        f"The largest is {at_least(worst_figure, of_worst)}, with "
        f"{design_name(order.axes, worst.design)}."
    )
    return " ".join([text, *caveats(known)])


def _source(order: Order, counted: str) -> str:
    versions = ", ".join(
        f"{name} {version}" for name, version in order.made_with.items() if name != "lostmotion"
    )
    return (
        f"seed {order.seed}: {counted}, in blocks of {several(order.block, 'pose')}; "
        f"{approach_text(order)}. "
        f"The same arm, values, counts, seed and versions ({versions}) "
        "on the same kind of processor give the same bytes, for any number of workers and "
        "interruptions."
    )


def _facts(arm: Arm, order: Order, outcomes: Sequence[Outcome]) -> dict[str, Any]:
    return {
        "arm": arm.name,
        "seed": order.seed,
        "poses": {"count": order.poses, "law": order.law, "independent_sets": order.sets},
        "robots": order.robots,
        "visits": order.visits,
        "axes": [{"key": axis.key, "values": list(axis.values)} for axis in order.axes],
        "designs": [
            {"name": design_name(order.axes, each.design), **_plain(each)} for each in outcomes
        ],
    }


def _plain(outcome: Outcome) -> dict[str, Any]:
    """Return a design as plain data, in SI."""
    lower = {} if outcome.lower is None else {"p95_lower_than_first": outcome.lower}
    return {
        "design": outcome.design,
        "stated": outcome.stated,
        **({"falls": asdict(outcome.falls)} if outcome.falls else {}),
        **{
            name: [_finite(each.value), _finite(each.low), _finite(each.high)]
            for name, each in (outcome.figures | lower).items()
        },
        "bound": bound(known_of(outcome)),
        "missing": {joint: list(kinds) for joint, kinds in outcome.known.missing.items()},
        "mass_kg": outcome.mass,
        "mass_not_stated": list(outcome.gearboxes_without_mass),
        "price": outcome.price,
        "price_not_stated": list(outcome.joints_without_price),
        "parts": [
            {"part": cost.part, "alone_m": cost.alone, "share": cost.share}
            for cost in outcome.costs
        ],
        "worst": [each.facts() for each in outcome.worst],
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _not_counted(outcomes: Sequence[Outcome]) -> str:
    """Return what a sweep of designs does not count."""
    prices = "" if any(each.price is not None for each in outcomes) else ", prices (none is stated)"
    without = list(
        dict.fromkeys(model for each in outcomes for model in each.gearboxes_without_mass)
    )
    return (
        f"not counted: {NOT_COUNTED}, strength of parts{prices}{without_mass(without)}; "
        "each design is compared by its position error at rest, its "
        f"mass{'' if prices else ' and its price'}"
    )
