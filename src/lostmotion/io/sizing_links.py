"""Links in a sizing file: limits for all of them, and of what sections each may be made."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, Final

from pydantic import Field, ValidationError, model_validator

from lostmotion.catalogue import materials
from lostmotion.errors import Problem, shown
from lostmotion.io.draft import plain
from lostmotion.io.limits import listed, nearest
from lostmotion.io.sizing_options import (
    OPTION_TABLES,
)
from lostmotion.io.toml import key_step
from lostmotion.io.validation_errors import problems
from lostmotion.parts.error_source import Part
from lostmotion.parts.family import Family, family_around
from lostmotion.parts.material import Material
from lostmotion.parts.section import Plain, refuse_section
from lostmotion.sizing.candidates import LinkOptions
from lostmotion.sizing.error_cache import TargetOf
from lostmotion.sizing.lightest import PAPER, Limits
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.io.validation_errors import Path as KeyPath
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.joint import Joint

TABLE: Final = "sizing"
LINK_EXAMPLE: Final = (
    '[sizing.links.A] with family = { kind = "tube", outer = "30 mm .. 200 mm", wall = "3 mm" }'
)
MOST_LINKS: Final = 100
# Range of sizes around a link's own section, in a selection for a target.
_NEAR_ITS_OWN: Final = (0.5, 2.0)
Stock = Annotated[tuple[Plain, ...], Field(min_length=1, max_length=500)]


class LinkChoice(Part):
    """Options for a link: a family or a list of sections, a new material, or `keep`."""

    family: Family | None = None
    stock: Stock | None = None
    material: Material | None = None
    keep: bool = False

    @model_validator(mode="after")
    def _states_one_choice(self) -> LinkChoice:
        stated = [
            name
            for name, value in (("family", self.family), ("stock", self.stock), ("keep", self.keep))
            if value
        ]
        if len(stated) > 1:
            raise refuse_section(
                " and ".join(stated), "one of family, stock and keep", "keep = true"
            )
        return self


class Plan(LinkChoice):
    """Limits for every link, and options for the links that are not named."""

    slope: Annotated[float, Quantity("rad", "0.5 arcmin", above=0, high=0.1)] = PAPER.slope
    deflection: Annotated[float, Quantity("", "2500", low=10, high=1e9)] = PAPER.deflection
    tilt: Annotated[float, Quantity("rad", "10 deg", low=0, high=math.pi)] | None = None
    step: Annotated[float, Quantity("m", "0.1 mm", low=0, high=0.1)] | None = None
    target: Annotated[float, Quantity("m", "0.5 mm", above=0, high=10)] | None = None
    target_of: TargetOf = "error"
    minimise: Annotated[str, Field(max_length=80)] = "mass"
    price_per_kg: Annotated[float, Quantity("", "12", low=0)] | None = None

    @property
    def limits(self) -> Limits:
        """Return the limits of every link."""
        return Limits(self.slope, self.deflection)


_ALSO: Final[dict[type[Any], dict[str, str]]] = {
    Plan: {"links": LINK_EXAMPLE, **{table: f"[sizing.{table}]" for table in OPTION_TABLES}},
}
_NUMBERS: Final = ("deflection", "price_per_kg")


def key_text(path: KeyPath) -> str:
    """Return a path of keys and indices as a file's reader writes it."""
    out = ""
    for step in path:
        out += (
            f"[{step}]"
            if isinstance(step, int)
            else f".{key_step(plain(step))}"
            if out
            else key_step(plain(step))
        )
    return out


def checked_table(
    tree: dict[str, Any],
    model: type[LinkChoice],
    file: str,
    key_of: Any,  # noqa: ANN401
    mistakes: list[Problem],
) -> LinkChoice | None:
    """Check a table by its model; material may go by name."""
    known = materials()
    tree = {
        key: f"{value}" if key in _NUMBERS and type(value) in {int, float} else value
        for key, value in tree.items()
    }
    material = tree.get("material")
    if isinstance(material, str):
        if material in known:
            tree = {**tree, "material": known[material]}
        else:
            near = nearest(material, known)
            expected = f"a material of the catalogue: {listed(known)}; or a table"
            mistakes.append(
                Problem(
                    file,
                    key_of(("material",)),
                    shown(material),
                    expected,
                    f'material = "{near or "aluminium"}"',
                    near,
                )
            )
            tree = {key: value for key, value in tree.items() if key != "material"}
    try:
        return model.model_validate(tree, context={"text": True})
    except ValidationError as error:
        mistakes += problems(error, model, file, key_of, _ALSO)
        return None


def links_of(links: Any, file: str, mistakes: list[Problem]) -> dict[str, LinkChoice]:  # noqa: ANN401 - whatever a file holds
    """Return the choices stated for links, by the name of their joint; mistakes are added."""
    if not isinstance(links, dict) or len(links) > MOST_LINKS:
        found = shown(links) if not isinstance(links, dict) else f"{len(links)} links"
        mistakes.append(
            Problem(
                file,
                f"{TABLE}.links",
                found,
                "a table of links by the name of their joint",
                LINK_EXAMPLE,
            )
        )
        return {}
    out = {}
    for name, stated in links.items():
        if not isinstance(stated, dict):
            mistakes.append(
                Problem(
                    file, key_text((TABLE, "links", name)), shown(stated), "a table", LINK_EXAMPLE
                )
            )
            continue
        choice = checked_table(
            stated,
            LinkChoice,
            file,
            lambda where, name=name: key_text((TABLE, "links", name, *where)),
            mistakes,
        )
        if choice is not None:
            out[name] = choice
    return out


def link_options_of(
    plan: Plan,
    named: dict[str, LinkChoice],
    arm: Arm,
    file: str,
    mistakes: list[Problem],
    *,
    needed: bool,
) -> dict[str, LinkOptions]:
    """Return the options of each link to size; mistakes are named links that cannot be sized, and
    no link where one is needed.
    """
    before = len(mistakes)
    out: dict[str, LinkOptions] = {}
    for joint in arm.joints:
        own = named.get(joint.name)
        options = own if own is not None and (own.family or own.stock or own.keep) else plan
        if options.keep:
            continue
        material = (own.material if own is not None else None) or plan.material
        section = joint.link.section
        choice = options.family or options.stock
        if choice is None:
            choice = (
                family_around(section)
                if plan.target is None
                else family_around(section, *_NEAR_ITS_OWN)
            )
        missing = _missing(joint, has_choice=choice is not None, has_material=material is not None)
        if missing and own is not None:
            mistakes.append(Problem(file, key_text((TABLE, "links", joint.name)), *missing))
        elif not missing and choice is not None:
            out[joint.name] = LinkOptions(choice, material)
    if needed and not out and len(mistakes) == before:
        expected = (
            "at least one link with a section and a material, or a family and a material for one "
            "without"
        )
        mistakes.append(
            Problem(
                file, TABLE, "no link to size", expected, 'material = "aluminium" beside the family'
            )
        )
    return out


def _missing(joint: Joint, *, has_choice: bool, has_material: bool) -> tuple[str, str, str] | None:
    link = joint.link
    if not link.reach:
        return "a link without a length", "a link with a length", "keep = true"
    if not has_choice:
        return (
            "a link without a section of stated sizes, and no family",
            "a family or stock",
            LINK_EXAMPLE,
        )
    if not has_material and (link.section is None or link.material is None):
        return "a link without one material", "its material", 'material = "aluminium"'
    return None
