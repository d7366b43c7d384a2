"""Data that ships with the package, each value with its source."""

from __future__ import annotations

import functools
import importlib.resources
import tomllib

from lostmotion.parts.link import Material


@functools.cache
def materials() -> dict[str, Material]:
    """Which materials are known by name? Typical values at room temperature; isotropic; `scatter` is the ± share by which Young's modulus differs.

    In SI: Pa, kg/m^3. A material of your own belongs in the arm file, under [materials.NAME].
    """
    text = importlib.resources.files(__name__).joinpath("materials.toml").read_text(encoding="utf-8")
    return {name: Material.model_validate(entry, context={"text": True}) for name, entry in tomllib.loads(text).items()}
