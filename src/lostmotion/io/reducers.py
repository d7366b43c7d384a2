"""Reducers by the maker's name, wherever an arm file may describe a gearbox.

    gearbox = "RV-40E-121"                                           # the maker's own name, with
                                                                     its ratio
    gearbox = { catalogue = "RV-40E", ratio = 121, backlash = "0.4 arcmin" }   # what is stated goes
    before the catalogue
    gearbox = { catalogue = "CSG-25-100", values = "typical" }       # typical values where the
    maker prints upper limits; default "limit" [gearboxes.shoulder]
    # the same for joints to share
    catalogue = "CSG-25-100"

A gearbox of that name under [gearboxes] goes before the catalogue, and so do rows of the user's own
(`own_reducers`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, TypeGuard

from lostmotion.catalogue.gearboxes import by_model, find_gearbox, gearbox_models
from lostmotion.errors import InputError, shown
from lostmotion.io.field_schema import inside, models, tag
from lostmotion.io.limits import nearest
from lostmotion.io.own_reducers import take_reducers
from lostmotion.parts.gearbox.kinds import DEFAULT_KIND
from lostmotion.parts.joint import RevoluteJoint

if TYPE_CHECKING:
    from lostmotion.catalogue.gearboxes import Rows
    from lostmotion.io.draft import Draft
    from lostmotion.io.validation_errors import Path

KEY: Final = "catalogue"
VALUES: Final = "values"
_EXAMPLE: Final = "RV-40E-121"
# What a turning joint's gearbox by catalogue takes besides the fields of its model.
ALSO: Final = {
    model: {KEY: f'{KEY} = "{_EXAMPLE}"', VALUES: f'{VALUES} = "typical"'}
    for model in models(inside([RevoluteJoint], "gearbox"))
    if tag(model) == DEFAULT_KIND
}


def place_reducers(draft: Draft) -> None:
    """Put rows of the catalogue where gearboxes name them; note what is wrong with a name, and what
    each row leaves open.
    """
    rows, mistakes = take_reducers(draft.file, draft.tree)
    draft.mistakes += mistakes
    own = by_model(rows)
    shared = draft.tree.get("gearboxes", {})
    shared = shared if isinstance(shared, dict) else {}
    placed = []
    for name, stated in shared.items():
        _refuse_values_alone(draft, stated, ("gearboxes", name))
        if _names_row(stated) and not draft.full:
            shared[name] = _with_row(draft, stated, ("gearboxes", name), KEY, own)
            placed.append(shared[name])
    for index, joint in draft.joints:
        path: Path = ("joints", index)
        stated = joint.get("gearbox")
        _refuse_values_alone(draft, stated, (*path, "gearbox"))
        if stated == KEY and KEY not in shared:
            expected = (
                "one gearbox, such as a reducer of the catalogue by its name; `lostmotion size` "
                "selects among all, by [sizing.gearboxes]"
            )
            draft.refuse(
                (*path, "gearbox"), shown(joint.pop("gearbox")), expected, f'gearbox = "{_EXAMPLE}"'
            )
            continue
        if isinstance(stated, str) and stated not in shared and _means_reducer(stated, shared, own):
            joint["gearbox"] = _with_row(draft, {KEY: stated}, path, "gearbox", own)
            placed.append(joint["gearbox"])
        elif _names_row(stated):
            joint["gearbox"] = _with_row(draft, stated, (*path, "gearbox"), KEY, own)
            placed.append(joint["gearbox"])
        gearbox = (
            shared.get(stated)
            if isinstance(stated, str) and stated in shared
            else joint.get("gearbox")
        )
        if gearbox is not None and any(gearbox is row for row in placed):
            _check_joint(draft, joint, gearbox, path)


def _refuse_values_alone(draft: Draft, stated: Any, path: Path) -> None:  # noqa: ANN401 - whatever a file holds
    """Refuse a selection of catalogue values in a gearbox that names no row of the catalogue, and
    take it out.
    """
    if (
        isinstance(stated, dict)
        and VALUES in stated
        and KEY not in stated
        and stated.get("kind", DEFAULT_KIND) == DEFAULT_KIND
    ):
        found = f"{shown(stated.pop(VALUES))} in a gearbox that names no reducer of the catalogue"
        draft.refuse(
            (*path, VALUES),
            found,
            f"{KEY} with a maker's name beside it, or no {VALUES}",
            f'{KEY} = "{_EXAMPLE}", {VALUES} = "typical"',
        )


def _names_row(stated: Any) -> TypeGuard[dict[str, Any]]:  # noqa: ANN401 - whatever a file holds
    return (
        isinstance(stated, dict)
        and KEY in stated
        and stated.get("kind", DEFAULT_KIND) == DEFAULT_KIND
    )


def _means_reducer(name: str, shared: dict[str, Any], own: Rows) -> bool:
    """Return whether a name that is not under [gearboxes] is one of the catalogue, or a slip of one
    rather than of a shared gearbox.
    """
    try:
        find_gearbox(name, own=own)
    except InputError as error:
        # A known name whose ratio is missing or unknown has no near name: the catalogue reports
        # what it lacks.
        return any(name.startswith(model) for model in (*own, *gearbox_models())) or (
            bool(error.problems[0].nearest) and not nearest(name, shared)
        )
    return True


def _with_row(
    draft: Draft, stated: dict[str, Any], path: Path, key: str, own_rows: Rows
) -> dict[str, Any]:
    """Add what the row says that is named in `stated`; what is stated goes before it. `key` is
    where the user wrote the name.
    """
    own = {name: value for name, value in stated.items() if name not in {KEY, VALUES}}
    values = stated.get(VALUES, "limit")
    name = stated[KEY]
    if not isinstance(name, str):
        draft.refuse(
            (*path, key),
            shown(name),
            "the name of a reducer of the catalogue",
            f'{key} = "{_EXAMPLE}"',
        )
        return own
    try:
        row, ratio = find_gearbox(name, float(own["ratio"]) if "ratio" in own else None, own_rows)
    except InputError as error:
        problem = error.problems[0]
        draft.refuse(
            (*path, key),
            problem.found,
            problem.expected,
            f'{key} = "{problem.example}"',
            problem.nearest,
        )
        return own
    except (TypeError, ValueError, OverflowError):
        return own  # the model reports what is wrong with the ratio
    if values not in ("limit", "typical"):
        draft.refuse(
            (*path, VALUES),
            shown(values),
            "limit (where nothing is stated) or typical",
            f'{VALUES} = "typical"',
        )
        values = "limit"
    elif values == "typical" and not row.typical_fields:
        found = f'"typical" for {name}, of which no typical value is known'
        example = (
            f'{VALUES} = "limit", or the values that you know: {{ {KEY} = "{name}", backlash = '
            f'"0.4 arcmin" }}'
        )
        draft.refuse(
            (*path, VALUES),
            found,
            "limit, or a reducer of which the catalogue knows typical values",
            example,
        )
    draft.note(row.note(name, own, values))
    return row.with_stated(
        {"model": name, **({} if ratio is None else {"ratio": ratio}), **own}, values
    )


def _check_joint(draft: Draft, joint: dict[str, Any], gearbox: dict[str, Any], path: Path) -> None:
    """Refuse a reducer on a sliding joint, and one without its ratio where an encoder's errors are
    divided by it.
    """
    encoder, encoders = joint.get("encoder"), draft.tree.get("encoders", {})
    if isinstance(encoder, str) and isinstance(encoders, dict):
        encoder = encoders.get(encoder)
    name = gearbox.get("model", "")
    if joint.get("type") == "prismatic":
        expected = "a gearbox by lengths and forces on a sliding joint; those of the catalogue turn"
        draft.refuse(
            (*path, "gearbox"), shown(name), expected, 'gearbox = { stiffness = "200 N/µm" }'
        )
        joint.pop("gearbox")
    elif (
        name
        and "ratio" not in gearbox
        and isinstance(encoder, dict)
        and encoder.get("side", "motor") == "motor"
        and "ratio" not in encoder
    ):
        expected = "the ratio behind the name: the encoder's errors reach the output divided by it"
        draft.refuse(
            (*path, "gearbox"),
            f"{shown(name)} without its ratio",
            expected,
            f'gearbox = "{name}-121"',
        )
