"""The figures of a yield: robots that keep a target, as things are and with the sizes that the target asks for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from lostmotion.reporting.sheet import Figure, Row, Section, several

if TYPE_CHECKING:
    from collections.abc import Iterable
    from typing import Any

    from lostmotion.analyses.targets.allocation import Joint
    from lostmotion.analyses.targets.targets import Targets
    from lostmotion.analyses.targets.yield_ import Judged, Yield

# What a robot is judged by, in the words of a row.
JUDGED_BY: Final[dict[Judged, str]] = {
    "error": "{share:g} % of its positions within it",
    "worst accuracy": "AP within it at every pose",
    "repeatability": "RP, averaged over the poses, within it",
    "worst repeatability": "RP within it at every pose",
}
_WIDTHS: Final = (0.1, 0.05, 0.02, 0.01)


def yield_section(found: Targets, target: Figure) -> Section:
    """Return the yield as things are, and how many robots an interval of some width takes."""
    first = found.yields[0]
    at = f"at a yield of {yield_figure(first)}"
    rows = _rows(found.yields)
    rows += [Row(f"robots for an interval {100 * width:g} % wide", (Figure(first.robots_for(width), "1"),), at) for width in _WIDTHS]
    note = "the robots of the study with this seed at these poses; an exact interval (Clopper and Pearson) that counts robots"
    return Section("yield", f"Yield: robots that keep {target}", ("value",), tuple(rows), note)


def allocated_section(found: Targets, target: Figure) -> list[Section]:
    """Return the yield with all items sized together; no section where no such sizes exist."""
    rows = [row for name, joint in allocated(found) for row in _rows(joint.yields, f"{name.replace('_', ' ')}: ")]
    note = (
        "the same robots with the errors of the sizes above, those not limiting at their largest usual size. A target that a share of all positions "
        "meets is missed by many robots, for each is judged by itself"
    )
    return [Section("yield_allocated", f"Yield with the allocated sizes: robots that keep {target}", ("value",), tuple(rows), note)] if rows else []


def allocated(found: Targets) -> list[tuple[str, Joint]]:
    """Return the ways in which all items are sized together, by name."""
    both = (("equal_factor", found.equal_factor), ("equal_effect", found.equal_effect))
    return [(name, joint) for name, joint in both if joint is not None]


def yield_figure(one: Yield) -> Figure:
    """Return the share of robots that keep the target."""
    low, high = one.interval
    counted = f"{several(one.robots, 'robot')} x {several(one.visits, 'visit')} x {several(one.poses, 'pose')}"
    return Figure(100 * one.share, "%", 100 * low, 100 * high, counted)


def yield_facts(yields: Iterable[Yield]) -> list[dict[str, Any]]:
    """Return yields as plain data."""
    return [{"judged_by": one.judged, "within": one.within, "robots": one.robots, "interval": list(one.interval)} for one in yields]


def _rows(yields: Iterable[Yield], before: str = "") -> list[Row]:
    return [
        Row(
            before + JUDGED_BY[one.judged].format(share=100 * one.share_of_positions),
            (yield_figure(one),),
            f"{one.within} of {several(one.robots, 'robot')}",
        )
        for one in yields
    ]
