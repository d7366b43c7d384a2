"""Clearances and fits by the standards' names, wherever a file describes a bearing.

clearance = "CN"        # ISO 5753-1: C2, CN, C3, C4 of a deep-groove ball or a cylindrical roller
                        bearing, by its bore
shaft_fit = "k5"        # ISO 286-2 zone of the shaft in a bore of the normal class (ISO 492); or
                        shaft_interference = "13 µm ± 11 µm" housing_fit = "H7"      # the same for
                        the outer ring; or housing_interference
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from lostmotion.catalogue.clearances import (
    clearance_of_group,
    clearance_warning,
    interference_of_zone,
)
from lostmotion.errors import InputError, shown
from lostmotion.io.provenance import rename_assumed
from lostmotion.parts.bearing.crossed_rollers import CrossedRollerBearing
from lostmotion.parts.bearing.pair import BallPair, RollerPair
from lostmotion.unit_registry import UnitError
from lostmotion.units import read_quantity

if TYPE_CHECKING:
    from pydantic import BaseModel

    from lostmotion.catalogue.clearances import Bearing
    from lostmotion.io.draft import Draft
    from lostmotion.io.validation_errors import Path

# Which table of clearances belongs to a kind of bearing; the standard has none for crossed rollers.
TABLES: Final[dict[str, Bearing]] = {
    "ball pair": "deep-groove ball",
    "roller pair": "cylindrical roller",
}
# The key of a fit, the field that it fills, the size it goes by, and an example.
_FITS: Final = (
    ("shaft_fit", "shaft_interference", "bore", "shaft", "k5"),
    ("housing_fit", "housing_interference", "outside_diameter", "housing", "H7"),
)
# What bearings by their drawing take besides the fields of their models.
ALSO: Final[dict[type[BaseModel], dict[str, str]]] = {
    model: {key: f'{key} = "{zone}"' for key, _, _, _, zone in _FITS}
    for model in (BallPair, RollerPair, CrossedRollerBearing)
}


def place_clearances(draft: Draft) -> None:
    """Put dimensions where bearings name groups and zones; note what is wrong with a name, and what
    speaks against an assumed clearance.
    """
    shared = draft.tree.get("bearings", {})
    for name, stated in shared.items() if isinstance(shared, dict) else ():
        _place(draft, stated, ("bearings", name))
    for index, joint in draft.joints:
        _place(draft, joint.get("bearing"), ("joints", index, "bearing"))


def _place(draft: Draft, stated: Any, path: Path) -> None:  # noqa: ANN401 - whatever a file holds
    kinds = {str(model.model_fields["kind"].default) for model in ALSO}
    kind = stated.get("kind") if isinstance(stated, dict) else None
    if not isinstance(kind, str) or kind not in kinds or draft.full:
        return
    rename_assumed(stated, {key: field for key, field, *_ in _FITS if key in stated})
    group = stated.get("clearance")
    bore, outside = (_size(stated.get(key)) for key in ("bore", "outside_diameter"))
    if isinstance(group, str) and group.strip()[:1].upper() == "C":
        stated.pop("clearance")
        if kind not in TABLES:
            draft.refuse(
                (*path, "clearance"),
                shown(group),
                f"a length: the standard has no groups for a {kind}",
                'clearance = "-5 µm ± 3 µm"',
            )
        elif bore is not None and _group(
            draft, stated, group, TABLES[kind], bore, (*path, "clearance")
        ):
            doubt = clearance_warning(TABLES[kind], bore, group)
            if doubt:
                draft.note(doubt)
    for key, field, size, surface, zone in _FITS:
        if key in stated:
            _fit(
                draft,
                stated,
                (key, field, surface, zone),
                bore if size == "bore" else outside,
                path,
            )


def _group(
    draft: Draft, stated: dict[str, Any], group: str, table: Bearing, bore: float, path: Path
) -> bool:
    try:
        stated["clearance"] = clearance_of_group(table, bore, group)
    except InputError as error:
        problem = error.problems[0]
        draft.refuse(
            path,
            problem.found,
            f'{problem.expected}; or a length, "20 µm ± 8 µm"',
            f'clearance = "{problem.nearest or "20 µm ± 8 µm"}"',
            problem.nearest,
        )
        return False
    return True


def _fit(
    draft: Draft,
    stated: dict[str, Any],
    names: tuple[str, str, str, str],
    size: float | None,
    path: Path,
) -> None:
    key, field, surface, example = names
    zone = stated.pop(key)
    if field in stated:
        draft.refuse(
            (*path, key), f"{key} beside {field}", "one of the two", f'{key} = "{example}"'
        )
        return
    if not isinstance(zone, str):
        draft.refuse(
            (*path, key),
            shown(zone),
            f"a zone of ISO 286-2 for the {surface}",
            f'{key} = "{example}"',
        )
        return
    if size is None:
        return  # the model reports what is wrong with the size
    try:
        stated[field] = interference_of_zone(
            "shaft" if surface == "shaft" else "housing", size, zone
        )
    except InputError as error:
        problem = error.problems[0]
        stating = f'{field} = "13 µm ± 11 µm"'
        # where the size is outside the table no zone helps
        naming = (
            f'{key} = "{problem.nearest or example}"' if problem.found == shown(zone) else stating
        )
        draft.refuse(
            (*path, key),
            problem.found,
            f"{problem.expected}; or {stating}",
            naming,
            problem.nearest,
        )


def _size(stated: Any) -> float | None:  # noqa: ANN401 - whatever a file holds
    try:
        return read_quantity(stated, "m").nominal if isinstance(stated, str) else None
    except UnitError:
        return None
