"""Predict how accurate a robot arm will be before it is built, where in its workspace, and which
part is to blame.

>>> import lostmotion
>>> s = lostmotion.study("z-arm.toml", robots=1000, visits=30, seed=1)
>>> s.summary()
>>> s.report("out/")

Every public name stands once, with its home, in `__init__.pyi`. Names are loaded when first used,
so that `import lostmotion` takes no time.
"""

from __future__ import annotations

import importlib
import importlib.util
from typing import Any

import lostmotion.source_hash  # noqa: F401 - notes first how the source is, whatever is imported later
from lostmotion.public_names import HOMES
from lostmotion.public_names import QUESTIONS as QUESTIONS
from lostmotion.version import __version__ as __version__

__all__ = list(HOMES)

# Former functions of (arm, q), by what replaces them in `state_of(arm, q)`.
_OF_STATE = {
    "frames": "frames",
    "wrenches": "wrenches",
    "compliance": "compliance",
    "deflection": "deflection(wrench)",
}


def __getattr__(name: str) -> Any:  # noqa: ANN401 - whatever stands behind the name
    """Load a public name from its home when it is first asked for."""
    value = (
        getattr(importlib.import_module(HOMES[name]), name)
        if name in HOMES
        else _of_extension(name)
    )
    if value is None:
        now = f": use lostmotion.state_of(arm, q).{_OF_STATE[name]}" if name in _OF_STATE else ""
        raise AttributeError(f"module 'lostmotion' has no attribute '{name}'{now}")
    globals()[name] = value
    return value


def _of_extension(name: str) -> Any:  # noqa: ANN401 - a question
    """Return a question of another installed package; None where there is none of this name."""
    # Python asks for a module's name, too, before it imports it
    if name.startswith("_") or importlib.util.find_spec(f"{__name__}.{name}") is not None:
        return None
    from lostmotion.extensions import question_named

    return question_named(name)


def __dir__() -> list[str]:
    """List the public names, with the questions of other installed packages."""
    from lostmotion.extensions import extensions

    return [*__all__, *extensions("questions")]
