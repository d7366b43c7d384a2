"""Reducers by the name their maker gives them, with the ratio behind it where that is stated: RV-40E, RV-40E-121, CSG-25-100."""

from __future__ import annotations

import functools
import re
from typing import Annotated, Any, Final, NoReturn

from pydantic import Field

from lostmotion.catalogue import packaged
from lostmotion.errors import InputError, Problem, nearest, shown
from lostmotion.parts.source import AngularStiffness, Part, TorqueAmount

# Who states one of these fields says in other words what the row says in those: they go.
_REPLACES: Final = {"backlash": {"lost_motion", "lost_motion_torque"}, "lost_motion": {"backlash"}, "stiffness": {"zone_torques"}}
_SOUGHT: Final = ("lost_motion", "backlash", "hysteresis", "transmission_error", "stiffness_scatter")
_CODE: Final = re.compile(r"(?P<model>.+?)(?:-(?P<ratio>[0-9]{1,6}(?:\.[0-9]{1,6})?))?")


class GearboxRow(Part):
    """One row of the catalogue: what a maker prints of a size, and from where it is known.

    models          names under which it is found
    ratio           the row holds for this ratio only; ratio_above: for all above; neither: for every ratio
    part            the fields of a turning joint's gearbox, as text with units
    upper_limits    fields for which the maker prints a limit and no value
    moment_rigidity of the main bearing against tilting; with acceleration_torque and emergency_torque kept as data
    printed         the maker's figures where `part` says them in other words
    source          with its confidence: [R] read, [M 95] from memory, 95 % sure
    """

    models: Annotated[list[str], Field(min_length=1)]
    maker: str
    ratio: float | None = None
    ratio_above: float | None = None
    part: dict[str, Any]
    upper_limits: tuple[str, ...] = ()
    moment_rigidity: AngularStiffness | None = None
    acceleration_torque: TorqueAmount | None = None
    emergency_torque: TorqueAmount | None = None
    printed: str = ""
    source: Annotated[str, Field(min_length=1)]

    @property
    def unstated(self) -> list[str]:
        """Name the errors of which the row says nothing, so that they count as none."""
        said = set(self.part) | ({"backlash"} if "lost_motion" in self.part else {"lost_motion"} if "backlash" in self.part else set())
        return [name for name in _SOUGHT if name not in said]

    @property
    def ratios(self) -> str:
        """Say in words for which ratios the row holds."""
        if self.ratio is not None:
            return f"{self.ratio:g}"
        return "any ratio" if self.ratio_above is None else f"above {self.ratio_above:g}"

    def holds_for(self, ratio: float) -> bool:
        """Tell whether the row holds for a ratio."""
        return (self.ratio is None or ratio == self.ratio) and (self.ratio_above is None or ratio > self.ratio_above)

    def with_own(self, stated: dict[str, Any]) -> dict[str, Any]:
        """Which fields does a gearbox get whose owner states some of them? Theirs go before the row's."""
        replaced = {other for name in stated for other in _REPLACES.get(name, ())}
        kept = {name: value for name, value in self.part.items() if name not in replaced}
        return {"kind": "catalogue", **kept, **stated}

    def note(self, name: str, stated: dict[str, Any]) -> str:
        """Say in one line what a user of this row should know of the fields they did not state themselves."""
        fields = self.with_own(stated)
        limits = [field for field in self.upper_limits if field in fields and field not in stated]
        silent = [field for field in self.unstated if field not in stated]
        words = [f"{_and(limits)} {'is' if len(limits) == 1 else 'are'} the maker's upper limit"] if limits else []
        words += [f"nothing is said of {_and(silent)}, taken as none"] if silent else []
        return f"{name} is taken from the catalogue" + "".join(f"; {each}" for each in words) + f". Source: {self.source}"


@functools.cache
def gearboxes() -> tuple[GearboxRow, ...]:
    """Which reducers are known? In the order of the data file: by maker, series, size and ratio."""
    return tuple(GearboxRow.model_validate(row, context={"text": True}) for row in packaged("gearboxes.toml")["reducers"])


@functools.cache
def gearbox_models() -> tuple[str, ...]:
    """Under which names are reducers found, without a ratio behind them?"""
    return tuple(dict.fromkeys(name for row in gearboxes() for name in row.models))


def find_gearbox(name: str, ratio: float | None = None) -> tuple[GearboxRow, float | None]:
    """Which row belongs to this name, and which ratio was stated: in the name ("CSG-25-100"), beside it, or not at all (None)?

    Raises InputError with one problem for an unknown name (with the nearest known one), for a name that needs its ratio and has none,
    for two ratios that differ, and for a ratio of which the rows say nothing.
    """
    model, behind = name, None
    if model not in gearbox_models():
        match = _CODE.fullmatch(name)
        if match is not None and match["ratio"]:
            model, behind = match["model"], float(match["ratio"])
    rows = [row for row in gearboxes() if model in row.models]
    if not rows:
        near = nearest(name, [*gearbox_models(), *(f"{known}-{behind:g}" for known in gearbox_models() if behind)])
        makers = ", ".join(f"{row.models[0]} … by {row.maker}" for row in {row.maker: row for row in reversed(gearboxes())}.values())
        _refuse(shown(name), f"a reducer of the catalogue ({makers}), with or without its ratio", near or "RV-40E-121", near)
    if behind is not None and ratio is not None and behind != ratio:
        _refuse(f"{shown(name)} with the ratio {ratio:g}", "one ratio, in the name or beside it", f"{model}-{ratio:g}")
    ratio = behind if ratio is None else ratio
    fitting = [row for row in rows if ratio is not None and row.holds_for(ratio)]
    choices = _or([row.ratios for row in rows])
    if ratio is None:
        if len(rows) > 1:
            _refuse(
                f"{shown(name)} without its ratio", f"the ratio behind it, for the stiffness depends on it: {choices}", f"{model}-{_typical(rows)}"
            )
        fitting = rows
    if not fitting:
        _refuse(f"{shown(model)} with the ratio {ratio:g}", f"a ratio of which the maker's figures are known: {choices}", f"{model}-{_typical(rows)}")
    return fitting[0], ratio


def _typical(rows: list[GearboxRow]) -> str:
    return "100" if any(row.holds_for(100) for row in rows) else rows[0].ratios


def _refuse(found: str, expected: str, example: str, near: str = "") -> NoReturn:
    raise InputError([Problem("the catalogue", "gearboxes", found, expected, example, near)])


def _and(names: list[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _or(names: list[str]) -> str:
    return " or ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
