"""What comparisons of designs do not count, in one plain paragraph each."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterable

    from lostmotion.runs.summary import Outcome
    from lostmotion.studies.sizing.aimed import Aimed
    from lostmotion.studies.sizing.sizing import Sizing

# No command that compares designs computes any of these: all of them look at the arm at rest, cold and new.
_AT_REST: Final = "motion (acceleration torques, vibration, servo errors), motors, thermal growth, wear and life, collisions"


def of_sweep(outcomes: Iterable[Outcome]) -> str:
    """Return what a sweep of designs does not count."""
    silent = list(dict.fromkeys(model for each in outcomes for model in each.unweighed))
    return (
        f"not counted: {_AT_REST}, strength of parts, prices{_unweighed(silent)}; each design is compared by its position error at rest and its mass"
    )


def of_sizing(found: Sizing) -> str:
    """Return what the sizing of links by limits does not count."""
    return (
        f"not counted: {_AT_REST}, stresses and buckling of links, prices{_unweighed(found.sized.unweighed)}; gearboxes, bearings and joint masses "
        "stay as they are, however light the links become"
    )


def of_choice(found: Aimed) -> str:
    """Return what a choice of parts for a target does not count."""
    kinds = {each.slot.what for each in found.bought}
    chosen = [name for name, kind in (("links", "link"), ("gearboxes", "gearbox"), ("bearing clearances", "bearing")) if kind in kinds]
    prices = "" if found.worth.price else ", prices"
    bearings = "" if "bearing" in kinds else ", other bearing clearances than the arm's"
    silent = [
        *(each.chosen.name for each in found.bought if each.slot.what == "gearbox" and not each.slot.weighs and each.chosen.part is not None),
        *found.sized.unweighed,
    ]
    return (
        f"not counted: {_AT_REST}, stresses and buckling of links, moment ratings of gearbox bearings{prices}{bearings}"
        f"{_unweighed(silent)}; chosen are {', '.join(chosen) or 'no parts'} only, and gearboxes are rated against static torques"
    )


def _unweighed(models: Iterable[str]) -> str:
    named = ", ".join(dict.fromkeys(models))
    return f", mass of {named} (not stated: counted as none)" if named else ""
