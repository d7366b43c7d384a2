"""Data that ships with the package, each value with its source."""

from __future__ import annotations

import functools
import importlib.resources
import tomllib
from typing import Any

from lostmotion.parts.link import Material


def data_file(file: str) -> dict[str, Any]:
    """Return the content of one of the package's own data files: a new tree at each call,
    quantities still as text.
    """
    return tomllib.loads(
        importlib.resources.files(__name__).joinpath(file).read_text(encoding="utf-8")
    )


@functools.cache
def materials() -> dict[str, Material]:
    """Return the known materials by name: typical values at room temperature; `scatter` is the ±
    share by which the moduli differ.

    In SI: Pa, kg/m^3. Typical values are marked as assumed. Define other materials in the arm file,
    under [materials.NAME].
    """
    return {
        name: Material.model_validate(
            {"name": name, **entry, "assumed": [key for key in entry if key != "source"]},
            context={"text": True},
        )
        for name, entry in data_file("materials.toml").items()
    }
