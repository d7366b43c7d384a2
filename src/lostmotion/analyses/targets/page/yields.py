"""Tables of the yield: robots that meet a target, of the arm as stated and with the allocated
sizes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from lostmotion.error_model.arrival import rp_name
from lostmotion.reporting.sheet import Cell, several, table

if TYPE_CHECKING:
    from collections.abc import Iterable
    from typing import Any

    from lostmotion.analyses.targets.targets import Target
    from lostmotion.propagation.production_yield import Criterion, Yield
    from lostmotion.reporting.sheet import Section
    from lostmotion.sizing.allowances import Allocation

# What a robot is criterion by, as row labels.
CRITERION_LABELS: Final[dict[Criterion, str]] = {
    "error": "{share:g} % of its positions within it",
    "worst accuracy": "AP within it at every pose",
    "repeatability": "{rp}, averaged over the poses, within it",
    "worst repeatability": "{rp}, within it at every pose",
}
_WIDTHS: Final = (0.1, 0.05, 0.02, 0.01)


def yield_section(result: Target, target: Cell) -> Section:
    """Return the yield of the arm as stated, and the number of robots for narrower intervals."""
    first = result.yields[0]
    at = f"at a yield of {yield_figure(first)}"
    rows = [
        *_rows(result.yields),
        *(
            (f"robots for an interval {100 * width:g} % wide", first.robots_for(width), at)
            for width in _WIDTHS
        ),
    ]
    note = (
        "robots of the study with this seed at these poses; exact confidence interval (Clopper "
        "and Pearson), which counts robots"
    )
    return table("yield", f"Yield: robots that meet {target}", ["value"], rows, note)


def allocated_section(result: Target, target: Cell) -> list[Section]:
    """Return the yield with the allocated sizes; no section where no allocation exists."""
    rows = [
        row
        for name, allocation in allocated(result)
        for row in _rows(allocation.yields, f"{name.replace('_', ' ')}: ")
    ]
    note = (
        "the same robots with the allocated sizes, items that are not limiting at their "
        "largest usual size. The yield may be below the share of all "
        "positions, because each robot has to meet the target by itself"
    )
    title = f"Yield with the allocated sizes: robots that meet {target}"
    return [table("yield_allocated", title, ["value"], rows, note)] if rows else []


def allocated(result: Target) -> list[tuple[str, Allocation]]:
    """Return the allocations that exist, by name."""
    both = (("equal_factor", result.equal_factor), ("equal_effect", result.equal_effect))
    return [(name, allocation) for name, allocation in both if allocation is not None]


def yield_figure(one: Yield) -> Cell:
    """Return the share of robots that meet the target."""
    low, high = one.interval
    counted = (
        f"{several(one.robots, 'robot')} x {several(one.visits, 'visit')} x "
        f"{several(one.poses, 'pose')}"
    )
    return Cell(one.share, "%", low, high, counted)


def yield_facts(yields: Iterable[Yield]) -> list[dict[str, Any]]:
    """Return yields as plain data."""
    return [
        {
            "judged_by": one.criterion,
            "within": one.within,
            "robots": one.robots,
            "interval": list(one.interval),
        }
        for one in yields
    ]


def criterion_label(one: Yield) -> str:
    """Return what each robot of a yield is judged by."""
    return CRITERION_LABELS[one.criterion].format(
        share=100 * one.share_of_positions, rp=rp_name(one.approach)
    )


def _rows(yields: Iterable[Yield], prefix: str = "") -> list[tuple[str, Any, str]]:
    return [
        (
            prefix + criterion_label(one),
            yield_figure(one),
            f"{one.within} of {several(one.robots, 'robot')}",
        )
        for one in yields
    ]
