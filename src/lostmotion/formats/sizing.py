"""How an arm is to be sized: limits, and for each link the family of sections or the list of stock to choose from. A TOML of its own.

    [sizing]
    slope = "0.5 arcmin"            # the paper's condition (4), and what holds where nothing is said
    deflection = 2500               # the length of the link over this
    tilt = "10 deg"                 # the base may lean by so much; left out: it stands as the arm file says
    step = "0.1 mm"                 # free sizes come in whole steps of this
    family = { kind = "tube", outer = "30 mm .. 200 mm", wall = "3 mm" }

    [sizing.links.A]                # by the name of the joint; a range, a size, or a share of the leading size
    family = { kind = "box", height = "30 mm .. 150 mm", width = "60 % .. 100 %", wall = "2 mm .. 6 mm" }

    [sizing.links.B]                # a list
    stock = [{ kind = "tube", outer = "80 mm", wall = "2 mm" }, { kind = "tube", outer = "100 mm", wall = "2 mm" }]

    [sizing.links.roll]
    keep = true

A link of which nothing is said is sized among sections like its own. `material` gives a link another one, or one at all.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, Final, get_args

from pydantic import Field, ValidationError, model_validator

from lostmotion.catalogue import materials
from lostmotion.errors import Problem, shown
from lostmotion.formats.bounds import listed, nearest, refuse_all
from lostmotion.formats.mistakes import problems
from lostmotion.formats.toml import read_toml
from lostmotion.parts.family import Family, family_around
from lostmotion.parts.material import Material
from lostmotion.parts.section import Plain, Sized, refuse_section
from lostmotion.parts.source import Part
from lostmotion.studies.lightest import Limits
from lostmotion.studies.sizing import PAPER, Wanted
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.arm import Arm
    from lostmotion.formats.mistakes import Path as KeyPath
    from lostmotion.parts.joint import Joint

TABLE: Final = "sizing"
_EXAMPLE: Final = '[sizing] with slope = "0.5 arcmin", deflection = 2500'
_LINK_EXAMPLE: Final = '[sizing.links.A] with family = { kind = "tube", outer = "30 mm .. 200 mm", wall = "3 mm" }'
_MOST_LINKS: Final = 100
_SIZED: Final = get_args(get_args(Sized)[0])
Stock = Annotated[tuple[Plain, ...], Field(min_length=1, max_length=500)]


class LinkChoice(Part):
    """What a link may be made of: sections of a family, or a list of them; another material; or nothing, to be kept."""

    family: Family | None = None
    stock: Stock | None = None
    material: Material | None = None
    keep: bool = False

    @model_validator(mode="after")
    def _says_one_thing(self) -> LinkChoice:
        said = [name for name, there in (("family", self.family), ("stock", self.stock), ("keep", self.keep)) if there]
        if len(said) > 1:
            raise refuse_section(" beside ".join(said), "one of family, stock and keep", "keep = true")
        return self


class Plan(LinkChoice):
    """Limits for every link, and what the links not named may be made of."""

    slope: Annotated[float, Quantity("rad", "0.5 arcmin", above=0, high=0.1)] = PAPER.slope
    deflection: Annotated[float, Quantity("", "2500", low=10, high=1e9)] = PAPER.deflection
    tilt: Annotated[float, Quantity("rad", "10 deg", low=0, high=math.pi)] | None = None
    step: Annotated[float, Quantity("m", "0.1 mm", low=0, high=0.1)] = 1e-4

    @property
    def limits(self) -> Limits:
        """Give what every link may do."""
        return Limits(self.slope, self.deflection)


_ALSO: Final[dict[type[Any], dict[str, str]]] = {Plan: {"links": _LINK_EXAMPLE}}


def read_sizing(path: Path | None, options: dict[str, Any], arm: Arm) -> tuple[Plan, dict[str, Wanted]]:
    """What does this file, and do these options of a command line, ask of an arm? The limits, and the links to size by the name of their joint.

    `options` stand as keys of `[sizing]`, under their own names. Raises InputError with every mistake in file and options, also links that the arm
    has not, or that cannot be sized.
    """
    file = str(path) if path is not None else ""
    tree = read_toml(path) if path is not None else {}
    stated = tree.pop(TABLE, {})
    mistakes = [
        Problem(file, shown(key)[1:-1], f"an unknown key with {shown(value)}", f"one table [{TABLE}]", _EXAMPLE, nearest(key, [TABLE]))
        for key, value in list(tree.items())[:_MOST_LINKS]
    ]
    if not isinstance(stated, dict):
        refuse_all([*mistakes, Problem(file, TABLE, shown(stated), "a table", _EXAMPLE)])
    twice = [key for key in options if key in stated]
    mistakes += [Problem(file, f"{TABLE}.{key}", f"stated here, and by --{key}", "one of the two", f"--{key} left out") for key in twice]
    merged = {**stated, **options}
    links = merged.pop("links", {})

    def key_of(where: KeyPath) -> str:
        if where and where[0] in options:
            return "--" + str(where[1] if where[0] == "family" and len(where) > 1 and where[1] in _OPTIONS else where[0])
        return _key((TABLE, *where))

    plan = _checked(merged, Plan, file, key_of, mistakes)
    named = _links(links, file, mistakes)
    names = {joint.name: joint for joint in arm.joints}
    for name in named:
        if name not in names:
            known = [joint.name for joint in arm.joints if joint.link.reach]
            mistakes.append(
                Problem(file, _key((TABLE, "links", name)), "no such joint", f"one of {listed(known)}", _LINK_EXAMPLE, nearest(name, known))
            )
    if mistakes or not isinstance(plan, Plan):
        refuse_all(mistakes)
    return plan, _wanted(plan, named, arm, file)


# Keys of a family that options of the command line are called after.
_OPTIONS: Final = ("kind", "outer", "wall")


def _key(path: KeyPath) -> str:
    out = ""
    for step in path:
        out += f"[{step}]" if isinstance(step, int) else f".{shown(step, 42)[1:-1]}" if out else shown(step, 42)[1:-1]
    return out


def _checked(tree: dict[str, Any], model: type[LinkChoice], file: str, key_of: Any, mistakes: list[Problem]) -> LinkChoice | None:  # noqa: ANN401
    """Check a table by its model; material may go by name."""
    known = materials()
    material = tree.get("material")
    if isinstance(material, str):
        if material in known:
            tree = {**tree, "material": known[material]}
        else:
            near = nearest(material, known)
            expected = f"a material of the catalogue: {listed(known)}; or a table"
            mistakes.append(Problem(file, key_of(("material",)), shown(material), expected, f'material = "{near or "aluminium"}"', near))
            tree = {key: value for key, value in tree.items() if key != "material"}
    try:
        return model.model_validate(tree, context={"text": True})
    except ValidationError as error:
        mistakes += problems(error, model, file, key_of, _ALSO)
        return None


def _links(links: Any, file: str, mistakes: list[Problem]) -> dict[str, LinkChoice]:  # noqa: ANN401 - whatever a file holds
    if not isinstance(links, dict) or len(links) > _MOST_LINKS:
        found = shown(links) if not isinstance(links, dict) else f"{len(links)} links"
        mistakes.append(Problem(file, f"{TABLE}.links", found, "a table of links by the name of their joint", _LINK_EXAMPLE))
        return {}
    out = {}
    for name, stated in links.items():
        if not isinstance(stated, dict):
            mistakes.append(Problem(file, _key((TABLE, "links", name)), shown(stated), "a table", _LINK_EXAMPLE))
            continue
        choice = _checked(stated, LinkChoice, file, lambda where, name=name: _key((TABLE, "links", name, *where)), mistakes)
        if choice is not None:
            out[name] = choice
    return out


def _wanted(plan: Plan, named: dict[str, LinkChoice], arm: Arm, file: str) -> dict[str, Wanted]:
    """Decide for each link of the arm; raises InputError where one that is named cannot be sized, and where none can."""
    mistakes = []
    out: dict[str, Wanted] = {}
    for joint in arm.joints:
        own = named.get(joint.name)
        asked = own if own is not None and (own.family or own.stock or own.keep) else plan
        if asked.keep:
            continue
        material = (own.material if own is not None else None) or plan.material
        choice = asked.family or asked.stock or (family_around(joint.link.section) if isinstance(joint.link.section, _SIZED) else None)
        lacks = _lacks(joint, has_choice=choice is not None, has_material=material is not None)
        if lacks and own is not None:
            mistakes.append(Problem(file, _key((TABLE, "links", joint.name)), lacks[0], lacks[1], lacks[2]))
        elif not lacks and choice is not None:
            out[joint.name] = Wanted(choice, material)
    if not out and not mistakes:
        expected = "at least one link with a section and a material, or a family and a material for one without"
        mistakes.append(Problem(file, TABLE, "no link to size", expected, 'material = "aluminium" beside the family'))
    if mistakes:
        refuse_all(mistakes)
    return out


def _lacks(joint: Joint, *, has_choice: bool, has_material: bool) -> tuple[str, str, str] | None:
    link = joint.link
    if not link.reach:
        return "a joint whose link leads nowhere", "a link with a length", "keep = true"
    if not has_choice:
        return "a link without a section that could be scaled, and no family", "a family or stock", _LINK_EXAMPLE
    if not has_material and (link.section is None or link.material is None):
        return "a link of no one material", "the material to make it of", 'material = "aluminium"'
    return None
