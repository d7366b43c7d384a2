"""Every value that went into an arm or a part: stated or assumed, with its source; and on how many
assumed sources it rests.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from lostmotion.parts.error_source import Part
from lostmotion.parts.provenance import ASSUMED, DEFAULT, DEFAULT_SCATTER, Sourced, value_keys

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from lostmotion.mechanism.arm import Arm

# Key of links and materials that counts only where a temperature is stated.
_EXPANSION: Final = "expansion"


@dataclass(frozen=True, slots=True)
class AssumedValue:
    """An assumed value: the part that has it ("joints.A.gearbox"), its key, the reason why it
    counts as assumed, and its source.

    origin  what it is counted with (`assumed_count`)
    """

    owner: str
    key: str
    reason: str
    source: str = ""
    origin: str = field(default="", compare=False)


@dataclass(frozen=True, slots=True)
class GivenValue:
    """A value that went in: the part that has it ("joints.A.gearbox"), its key, and the class of
    parts whose field it is.

    value   as the part holds it, in SI; None where the part has no value of its own, and computes
            one
    reason  why it counts as assumed; empty for a stated one
    whole   whether its part as a whole is marked as assumed, or comes from a preset; then it counts
            there, once
    origin  of an assumed value: as in `AssumedValue`
    """

    owner: str
    key: str
    part: type[Part]
    value: object
    reason: str = ""
    source: str = ""
    whole: bool = False
    origin: str = field(default="", compare=False)

    @property
    def state(self) -> str:
        """Return "stated", or why it counts as assumed."""
        return self.reason or (ASSUMED if self.whole else "stated")


def given_in_part(part: object, owner: str) -> tuple[GivenValue, ...]:
    """Return every value of one part and of the parts that it consists of; `owner` is the name of
    the part, for example "gearbox".
    """
    return tuple(value for value, _ in _walk(part, owner, "", _Origins(), levels=1))


def assumed_in_part(part: object, owner: str) -> tuple[AssumedValue, ...]:
    """Return every assumed value of one part and of the parts that it consists of; `owner` as in
    `given_in_part`.
    """
    return assumed_among(given_in_part(part, owner))


def assumed_among(given: Iterable[GivenValue]) -> tuple[AssumedValue, ...]:
    """Return the assumed ones of these values."""
    return tuple(
        AssumedValue(each.owner, each.key, each.reason, each.source, each.origin)
        for each in given
        if each.reason
    )


def bounded_members(part: object) -> tuple[str, ...]:
    """Return the members of a drawn gearbox that its drawing does not describe, each with its
    drawing; none for other parts.
    """
    return (
        tuple(f"{part!r} {member}" for member in getattr(part, "bounded", ()))
        if isinstance(part, Part)
        else ()
    )


def assumed_count(assumed: Iterable[AssumedValue], bounded: Iterable[str] = ()) -> int:
    """Return the number of assumed values, where those of one source count once.

    One source is a preset, a material, a row of the catalogue, and otherwise a part, of a drawn
    gearbox each member; parts that several joints share count once. Each bounded member of a drawn
    gearbox counts, and the scatter of a stated value does not. So stating a value in place of an
    assumed one never raises the count.

    bounded  from `bounded_members`
    """
    return len({each.origin for each in assumed if each.reason != DEFAULT_SCATTER} | set(bounded))


def any_assumed(value: object, *, elastic: bool = True) -> bool:
    """Return whether any value in a part is assumed; without `elastic`, the values of materials,
    which enter only its stiffness, are excluded.
    """
    return any(
        each.reason and not each.reason.startswith(DEFAULT) and (elastic or not holder.elastic_only)
        for each, holder in _walk(value, "", "", _Origins(), levels=0)
    )


class _Origins:
    """Origins of assumed values: the first place of every part, by its contents where several
    joints may share it.
    """

    def __init__(self) -> None:
        self._first: dict[str, str] = {}

    def of_part(self, part: Part, place: str) -> str:
        """Return the name of a part: of a material its contents, of a catalogue's part its model,
        of another the place where it was first.
        """
        if part.elastic_only:
            return repr(part)
        model = getattr(part, "model", "")
        if model:
            return f"model {model}"
        return self._first.setdefault(repr(part), place) if part.shareable else place


def given_in(arm: Arm) -> Iterator[GivenValue]:
    """Yield every value of an arm, once also where several joints share the part that it belongs
    to.
    """
    seen: set[tuple[str, str]] = set()
    names: dict[int, str] = {}
    origins = _Origins()
    places: list[tuple[str, object]] = [
        ("base", arm.base),
        ("tool", arm.tool),
        ("payload", arm.payload),
        ("environment", arm.environment),
    ]
    places += [(f"joints.{joint.name}", joint) for joint in arm.joints]
    for owner, part in places:
        for value, holder in _walk(part, owner, "", origins, levels=2):
            if holder.shareable and id(holder) not in names:
                names[id(holder)] = repr(holder)
            key = (names.get(id(holder), value.owner), value.key)
            if key not in seen and (value.key != _EXPANSION or arm.has_temperatures):
                seen.add(key)
                yield value


def _walk(
    value: object,
    owner: str,
    source: str,
    origins: _Origins,
    *,
    levels: int,
    origin: str = "",
    whole: bool = False,
) -> Iterator[tuple[GivenValue, Part]]:
    """Yield the values of a part and of the parts that it consists of, each with the part that has
    it; `whole` as in `GivenValue`.

    levels  how many levels of parts below this one have origins of their own; those below have that
            of their part, `origin`
    """
    if isinstance(value, tuple | list):
        for index, each in enumerate(value, 1):
            yield from _walk(
                each, f"{owner}.{index}", source, origins, levels=0, origin=origin, whole=whole
            )
    if not isinstance(value, Part):
        return
    owner = value.shared_name or owner
    assumptions: dict[str, str] = {}
    preset, model = None, type(value)
    if isinstance(value, Sourced):
        source = value.source or source
        assumptions = value.assumptions
        preset = getattr(value, "preset", None)
    inner = {name: getattr(value, name) for name in value_keys(model)}
    origin = origin or origins.of_part(value, owner)

    def origin_of(name: str) -> str:
        """Return the origin of a part that this one holds; empty where it is to have one by
        itself.
        """
        held = inner.get(name)
        if isinstance(held, Sourced) and (levels or held.elastic_only):
            return origins.of_part(held, f"{owner}.{name}")
        return origin

    for key in [
        *(key for key in inner if key in value.model_fields_set and key not in assumptions),
        *assumptions,
    ]:
        reason, held = assumptions.get(key, ""), inner.get(key)
        if not reason and (held is None or _has_parts(held)):
            continue
        # The source that the file quotes for its own values is not the source of a default.
        quoted = (
            preset.source
            if preset is not None and key in preset.keys
            else ""
            if reason.startswith(DEFAULT)
            else source
        )
        counted_with = reason if preset is not None and key in preset.keys else origin_of(key)
        yield (
            GivenValue(
                owner,
                key,
                model,
                None if _has_parts(held) else held,
                reason,
                quoted,
                whole,
                counted_with if reason else "",
            ),
            value,
        )
    for name, held in inner.items():
        marked = (
            whole
            or assumptions.get(name) == ASSUMED
            or (preset is not None and name in preset.keys)
        )
        yield from _walk(
            held,
            f"{owner}.{name}",
            source,
            origins,
            levels=max(levels - 1, 0),
            origin=origin_of(name),
            whole=marked,
        )


def _has_parts(value: object) -> bool:
    """Return whether a value is a part or consists of parts, whose own values are listed."""
    return isinstance(value, Part) or (
        isinstance(value, tuple | list) and any(isinstance(each, Part) for each in value)
    )
