"""Materials of the catalogue: laminates against classical laminate theory from their plies, all
others within physical limits.
"""

from __future__ import annotations

import numpy as np
import pytest

from lostmotion.catalogue import materials
from lostmotion.parts.elastic_link import ElasticLink
from lostmotion.parts.link import Link

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "laminates",
        "classical laminate theory from the plies",
        "stated digits",
    ),
)

# E along, E across, G (GPa), poisson: as the head of materials.toml states them.
PLIES = {
    "CFRP": (135.0, 9.0, 4.8, 0.30),
    "high modulus": (230.0, 7.5, 4.5, 0.28),
    "GFRP": (40.0, 9.0, 4.0, 0.27),
}
# Thermal expansion of the plies along and across, 1e-6/K, as the head of materials.toml states
# them.
PLY_EXPANSIONS = {"CFRP": (0.02, 22.5), "high modulus": (-0.5, 32.0), "GFRP": (6.6, 30.0)}
LAYUPS = {
    "UD": (0,),
    "60/40": (0, 0, 0, 45, -45),
    "quasi-isotropic": (0, 45, -45, 90),
    "±45": (45, -45),
}


def laminate(
    ply: tuple[float, float, float, float], angles: tuple[int, ...]
) -> tuple[float, float, float]:
    """Return Young's modulus along x, shear modulus and Poisson's ratio of a symmetric laminate in
    its plane, with plies at these angles (deg).
    """
    along, across, shear, nu = ply
    compliance = np.array(
        [[1 / along, -nu / along, 0], [-nu / along, 1 / across, 0], [0, 0, 1 / shear]]
    )
    whole = np.zeros((3, 3))
    for angle in np.radians(angles):
        c, s = np.cos(angle), np.sin(angle)
        strains = np.array(
            [[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]]
        )
        whole += strains.T @ np.linalg.inv(compliance) @ strains / len(angles)
    gives = np.linalg.inv(whole)
    return 1 / gives[0, 0], 1 / gives[2, 2], -gives[0, 1] / gives[0, 0]


def expansion(kind: str, angles: tuple[int, ...]) -> float:
    """Return the thermal expansion along x (1e-6/K) of the same laminate: its plies share one
    strain, and their stresses cancel.
    """
    along, across, shear, nu = PLIES[kind]
    stiffness = np.linalg.inv(
        [[1 / along, -nu / along, 0], [-nu / along, 1 / across, 0], [0, 0, 1 / shear]]
    )
    whole, force = np.zeros((3, 3)), np.zeros(3)
    for angle in np.radians(angles):
        c, s = np.cos(angle), np.sin(angle)
        strains = np.array(
            [[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]]
        )
        whole += strains.T @ stiffness @ strains
        force += strains.T @ stiffness @ [*PLY_EXPANSIONS[kind], 0.0]
    return float(np.linalg.solve(whole, force)[0])


LAMINATES = [name for name, material in materials().items() if material.shear_modulus is not None]


@pytest.mark.parametrize("name", LAMINATES)
def test_a_laminate_follows_from_its_plies(name: str):
    """Moduli and Poisson's ratio of every laminate are those of classical laminate theory, to the
    digits that are stated.
    """
    kind, layup = name.partition(", ")[0].split(" ", 1)
    kind = "high modulus" if "high" in name else kind
    young, shear, nu = laminate(PLIES[kind], LAYUPS[layup])
    material = materials()[name]
    assert material.expansion * 1e6 == pytest.approx(
        expansion(kind, LAYUPS[layup]), rel=4e-3, abs=5e-3
    )
    assert material.young * 1e-9 == pytest.approx(young, rel=4e-3)
    assert material.shear * 1e-9 == pytest.approx(shear, rel=4e-3)
    assert material.poisson == pytest.approx(nu, abs=6e-3)


def test_there_are_laminates_to_check():
    """Carbon and glass, unidirectional, quasi-isotropic, and for torsion."""
    assert {"CFRP UD", "CFRP quasi-isotropic", "CFRP ±45", "GFRP UD"} <= set(LAMINATES)


def test_laminate_theory_has_the_known_limits():
    """A quasi-isotropic laminate is isotropic in its plane, E = 2 G (1 + nu); a laminate of one ply
    is that ply.
    """
    young, shear, nu = laminate(PLIES["CFRP"], LAYUPS["quasi-isotropic"])
    assert young == pytest.approx(2 * shear * (1 + nu), rel=1e-12)
    assert laminate(PLIES["GFRP"], (0,)) == pytest.approx((40.0, 4.0, 0.27), rel=1e-12)


def test_expansions_are_those_of_the_standards():
    """Structural steel 12e-6/K (EN 1993-1-1), aluminium 23e-6/K (EN 1999-1-1); every material
    states one, and polymers without fibres expand most.
    """
    known = {name: material.expansion for name, material in materials().items()}
    assert (known["steel"], known["aluminium"]) == (pytest.approx(12e-6), pytest.approx(23e-6))
    assert None not in known.values()
    polymers = (
        "PLA",
        "PETG",
        "ABS",
        "ASA",
        "polycarbonate",
        "nylon",
        "SLA resin",
        "tough SLA resin",
        "PA12, SLS or MJF",
    )
    assert min(known[name] for name in polymers) > 2 * max(
        value for name, value in known.items() if name not in polymers
    )


@pytest.mark.parametrize("name", materials())
def test_every_material_stores_energy(name: str):
    """Scatter is stated, and an isotropic solid has a Poisson's ratio that leaves it stiff against
    pressure.
    """
    material = materials()[name]
    assert 0 < material.scatter <= 0.33
    assert material.shear_modulus is not None or material.poisson < 0.45


def test_shear_goes_into_torsion_and_not_into_bending():
    """A tube of ±45 carbon twists less and bends more than one of unidirectional carbon, by the
    ratios of the moduli.
    """
    tube = {"kind": "tube", "outer": 0.06, "wall": 0.002}
    along, across = (
        ElasticLink(
            Link(length=0.5, section=tube, material=materials()[name]), np.array([0, 1.0, 0])
        ).tip_compliance
        for name in ("CFRP UD", "CFRP ±45")
    )
    assert across[0, 0] / along[0, 0] == pytest.approx(4.8 / 34.9, rel=1e-9)
    assert across[1, 1] / along[1, 1] == pytest.approx(135 / 17, rel=1e-9)
