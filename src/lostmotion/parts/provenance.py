"""Provenance of the values of a part: stated by the user, assumed, or a maker's upper limit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self

from pydantic import Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from lostmotion.errors import Worded, nearest, shown
from lostmotion.parts.error_source import FRICTION_SCATTER_TEXT, Line, Part

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.parts.error_source import Friction

ASSUMED: Final = "assumed"
UPPER_LIMIT: Final = "maker's upper limit"
# The reason of a default begins with this word.
DEFAULT: Final = "default"
# The reason of a stated friction whose scatter alone is a default.
DEFAULT_SCATTER: Final = f"{DEFAULT} scatter, {FRICTION_SCATTER_TEXT}"
LONGEST_SOURCE: Final = 500
# Keys that identify a part or its provenance, or state its price: no error depends on them.
NO_VALUES: Final = frozenset(
    {
        "assumed",
        "source",
        "upper_limits",
        "preset",
        "kind",
        "type",
        "name",
        "model",
        "notes",
        "after",
        "passive",
        "price",
    }
)

Keys = Annotated[
    tuple[Annotated[Line, Field(max_length=80)], ...],
    Field(max_length=100),
    Worded("a list of keys that this table states", "[]"),
]


class Sourced(Part):
    """A part whose values have a provenance.

    assumed   keys of this table whose values are assumed: neither measured nor taken from a maker's
              data
    source    where the values come from, in one line
    """

    # Keys that count as assumed where they are not stated, with the reason.
    assumed_unless_stated: ClassVar[dict[str, str]] = {}
    assumed: Keys = ()
    source: Annotated[Line, Field(max_length=LONGEST_SOURCE)] = ""

    @field_validator("assumed", "upper_limits", check_fields=False)
    @classmethod
    def _names_keys(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        known = value_keys(cls)
        strange = [name for name in names if name not in known]
        if strange:
            near = nearest(strange[0], known)
            raise _refusal(
                f"{shown(strange[0])}, not a key of this table",
                f"keys of this table: {', '.join(known)}",
                near or known[0],
                near,
            )
        return names

    @model_validator(mode="after")
    def _assumes_what_it_states(self) -> Self:
        stated = [name for name in value_keys(type(self)) if name in self.model_fields_set]
        for listing in ("assumed", "upper_limits"):
            silent = [name for name in getattr(self, listing, ()) if name not in stated]
            if silent:
                near = nearest(silent[0], stated)
                expected = f"keys that this table states: {', '.join(stated) or 'none'}"
                raise _refusal(
                    f"{shown(silent[0])} in {listing}, without a value",
                    expected,
                    near or next(iter(stated), ""),
                    near,
                    listing,
                )
        return self

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason. Subclasses add their
        limits and the defaults that depend on other values.
        """
        silent = (
            key
            for key in self.assumed_unless_stated
            if key not in self.model_fields_set or getattr(self, key) is None
        )
        return {
            **dict.fromkeys(self.assumed, ASSUMED),
            **{key: self.assumed_unless_stated[key] for key in silent},
        }

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy with other values; a value that is set here is no longer an assumption or a
        limit.
        """
        changed = dict(update or {})
        for listing in ("assumed", "upper_limits"):
            names = getattr(self, listing, ())
            kept = tuple(name for name in names if name not in changed)
            if listing not in changed and kept != names:
                changed[listing] = kept
        return super().model_copy(update=changed or update, deep=deep)


class Preset(Part):
    """The class of parts whose typical values a part takes where its own are not stated.

    name    of the class, as in the catalogue
    keys    whose values are those of the class; they count as assumed
    source  where those values come from
    load    of the drive that they suit (N m or N), where they follow from it by a class of drive
    """

    name: Annotated[Line, Field(max_length=80)]
    keys: Keys = ()
    source: Annotated[Line, Field(max_length=LONGEST_SOURCE)] = ""
    load: float | None = None

    @property
    def reason(self) -> str:
        """Return why a value of the class counts as assumed."""
        return f"preset {self.name}" if self.load is None else f"class {self.name}"


class OfClass(Sourced):
    """A part that may take typical values of its class from a preset of the catalogue. In a file,
    `preset` is the name of the class.
    """

    preset: Preset | None = None

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, those of the preset with
        its name.
        """
        own = super().assumptions
        return (
            own
            if self.preset is None
            else {**own, **dict.fromkeys(self.preset.keys, self.preset.reason)}
        )

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy with other values; a value that is set here is no longer that of the
        preset.
        """
        if (
            self.preset is not None
            and update
            and "preset" not in update
            and set(update) & set(self.preset.keys)
        ):
            kept = tuple(key for key in self.preset.keys if key not in update)
            update = {**update, "preset": self.preset.model_copy(update={"keys": kept})}
        return super().model_copy(update=update, deep=deep)


def value_keys(model: type[Part]) -> list[str]:
    """Return the keys of a table that hold values, in order."""
    return [name for name in model.model_fields if name not in NO_VALUES]


def with_friction(
    assumptions: dict[str, str], key: str, friction: Friction | None
) -> dict[str, str]:
    """Return `assumptions` with the entry for a friction, or a scatter of it, that is not stated
    under `key`; none for a part without play.

    A friction that the part lists as assumed keeps its entry.
    """
    if friction is None or key in assumptions:
        return assumptions
    if friction.reason:
        return {**assumptions, key: f"{DEFAULT}, {friction.reason}, {FRICTION_SCATTER_TEXT}"}
    return {**assumptions, key: DEFAULT_SCATTER} if friction.scatter_assumed else assumptions


def _refusal(
    why: str, expected: str, key: str, near: str, listing: str = "assumed"
) -> PydanticCustomError:
    example = f'{listing} = ["{key}"]' if key else f"{listing} = []"
    return PydanticCustomError(
        "names", "{why}", {"why": why, "expected": expected, "example": example, "near": near}
    )
