"""Kinds of parts that other installed packages bring (`lostmotion.extensions`)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from lostmotion.extensions import extensions
from lostmotion.parts.bearing.bearing import BearingFigures
from lostmotion.parts.gearbox.gearbox import TurningFigures
from lostmotion.parts.gearbox.slide import SlideFigures

if TYPE_CHECKING:
    from collections.abc import Iterable

# What a kind must be: a gearbox of a turning joint, a drive of a sliding one, a bearing.
_BASES: Final[tuple[type[Any], ...]] = (TurningFigures, SlideFigures, BearingFigures)
_EXPECTED: Final = (
    "a class derived from one of "
    f"{', '.join(base.__name__ for base in _BASES)}, with kind: Literal[NAME] = NAME"
)


def kinds_of_extensions(own: Iterable[type[Any]], *bases: type[Any]) -> list[type[Any]]:
    """Return the kinds of other packages that derive from one of these bases, to stand beside
    `own`. Raises InputError for what is no kind, and for a name that another kind has.
    """
    out: list[type[Any]] = []
    taken = {name: "lostmotion" for each in own for name in _names(each)}
    for extension in extensions("parts").values():
        kind: type[Any] = extension.load(_EXPECTED, _is_kind)
        if not issubclass(kind, bases):
            continue
        for name in _names(kind):
            if name in taken:
                raise extension.refusal(
                    f"the name '{name}', which {taken[name]} uses", "a name of its own"
                )
            taken[name] = f"package {' '.join(extension.package)}"
        out.append(kind)
    return out


def _names(kind: type[Any]) -> tuple[str, str]:
    """Return the kind as a file states it, and the name of its class, which the schema uses."""
    return kind.model_fields["kind"].default, kind.__name__.partition("[")[0]


def _is_kind(value: object) -> bool:
    kind = getattr(value, "model_fields", {}).get("kind")
    return (
        isinstance(value, type)
        and issubclass(value, _BASES)
        and isinstance(getattr(kind, "default", None), str)
    )
