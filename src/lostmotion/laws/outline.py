"""Cross-sections of any outline, by finite elements with the package sectionproperties (the extra
`sections`).

Area and second moments are the polygon's own; torsion, shear factors and shear centre are solutions
of Saint-Venant's problem on a mesh of six-node triangles. The shear factor is that of equal energy,
which differs from Cowper's by a few per cent, and by more where the section is wide across the
force. Source: W. Pilkey, Analysis and Design of Elastic Beams, 2002.
"""

from __future__ import annotations

import functools
import importlib.util
import math
from typing import Final, TypeAlias

from lostmotion.laws.cross_sections import SectionValues

Points: TypeAlias = tuple[tuple[float, float], ...]
MISSING: Final = "the package sectionproperties, which is not installed"
INSTALL: Final = 'pip install "lostmotion[sections]"'
# Triangles per section. The error of the torsion constant is below 0.1 %, also with sharp inner
# corners, in a few seconds. Results are cached.
_TRIANGLES: Final = 1000
_SIDE: Final = 100.0  # the section is scaled to this size, which the mesher needs


def available() -> bool:
    """Return whether the package for sections of any outline is installed."""
    return importlib.util.find_spec("sectionproperties") is not None


def outline_error(points: Points, holes: tuple[Points, ...]) -> str:
    """Return why an outline with holes is not a valid section; empty for a valid one. Raises
    ImportError without the package.
    """
    import shapely

    shape = shapely.Polygon(points, holes)
    if not shape.is_valid:
        return str(shapely.is_valid_reason(shape))
    return "" if shape.area > 0 else "no area"


@functools.lru_cache(maxsize=256)
def outline_section(points: Points, holes: tuple[Points, ...], nu: float) -> SectionValues:
    """Return the properties about the centroid of a section with this outline and holes, corners
    (y, z) in m.

    Raises ImportError without the package.
    """
    import numpy as np
    import shapely
    from sectionproperties.analysis import Section
    from sectionproperties.pre import Geometry, Material

    shape = shapely.Polygon(points, holes)
    scale = _SIDE / math.sqrt(shape.area)
    shape = shapely.Polygon(np.array(points) * scale, [np.array(hole) * scale for hole in holes])
    geometry = Geometry(shape, material=Material("unit", 1.0, nu, 1.0, 1.0, "white"))
    geometry.create_mesh(mesh_sizes=[shape.area / _TRIANGLES])
    section = Section(geometry)
    section.calculate_geometric_properties()
    section.calculate_warping_properties()
    found = section.section_props
    i_y, i_z, i_yz = (float(value) / scale**4 for value in section.get_eic())
    y, z = (float(value) / scale for value in section.get_c())
    centre_y, centre_z = (float(value) / scale for value in section.get_sc())
    return SectionValues(
        area=float(shape.area) / scale**2,
        i_y=i_y,
        i_z=i_z,
        torsion=float(section.get_ej()) / scale**4,
        shear_y=float(found.a_sx) / float(shape.area),
        shear_z=float(found.a_sy) / float(shape.area),
        i_yz=i_yz,
        shear_yz=float(shape.area) / float(found.a_sxy),
        centre_y=centre_y - y,
        centre_z=centre_z - z,
    )
