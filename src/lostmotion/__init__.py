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
import pkgutil
import re
from typing import Any

import lostmotion.source_hash  # noqa: F401 - notes first how the source is, whatever is imported later
from lostmotion.version import __version__ as __version__

# Home of every public name, in reading order; those whose home is a `command` are questions, which
# the command line asks as well.
HOMES = {
    name: match[1]
    for match in re.finditer(
        r"^from (lostmotion\.\S+) import (.+)$",
        (pkgutil.get_data(__name__, "__init__.pyi") or b"").decode(),
        re.MULTILINE,
    )
    for name in re.findall(r"as (\w+)", match[2])
}
QUESTIONS = {name: home for name, home in HOMES.items() if home.endswith(".command")}
__all__ = [*HOMES]  # noqa: PLE0604 - names of the stub


def __getattr__(name: str) -> Any:  # noqa: ANN401 - whatever stands behind the name
    """Load a public name from its home when it is first asked for."""
    if name not in HOMES:
        raise AttributeError(f"module 'lostmotion' has no attribute '{name}'")
    value = getattr(importlib.import_module(HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names."""
    return __all__
