"""Materials of printed parts: modulus in and across the layers, with infill, under load over time
and at a temperature.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.catalogue import materials
from lostmotion.parts.bands import unknown_values, with_values
from lostmotion.parts.elastic_link import ElasticLink
from lostmotion.parts.link import Link
from lostmotion.parts.material import Material

PLASTIC: dict[str, Any] = {"young": "2.4 GPa", "poisson": 0.36, "density": "1200 kg/m^3"}


def material(**values: Any) -> Material:
    """Return a polymer with further values."""
    return Material.model_validate({**PLASTIC, **values}, context={"text": True})


def test_printing_by_extrusion_leaves_layers_and_infill_open():
    """A process of FFF adds ranges for what is not stated, as assumed values; other processes make
    solid, isotropic parts.
    """
    printed = material(process="FFF", infill="0.8", name="onyx")
    assert [each.key for each in unknown_values(printed)] == ["materials.onyx.across_layers"]
    assert printed.assumed == ("across_layers",)
    assert printed.infill == 0.8
    for process in ("SLA", "SLS", "MJF"):
        sintered = material(process=process)
        assert sintered.plate_modulus == sintered.standing_modulus == sintered.young
        assert not unknown_values(sintered)
    known = with_values(printed, {"materials.onyx.across_layers": 0.5})
    assert (known.standing_modulus, known.plate_modulus, known.modulus) == (
        1.2e9,
        pytest.approx(1.92e9),
        2.4e9,
    )


def test_time_and_temperature_soften_every_modulus():
    """Creep and temperature multiply, and act equally on Young's and the shear modulus, also of a
    link.
    """
    soft = material(
        load_time="1000 h", creep=[0.92, 0.79], temperature="84 °C", heat_deflection="145 °C"
    )
    assert soft.modulus == pytest.approx(2.4e9 * 0.79 * 0.75)
    assert soft.shear == pytest.approx(soft.modulus / (2 * 1.36))
    link = {"length": "200 mm", "section": {"kind": "rod", "diameter": "20 mm"}}
    axis = np.array([0.0, 1.0, 0.0])
    bent = [
        ElasticLink(
            Link.model_validate({**link, "material": each}, context={"text": True}), axis
        ).tip_compliance
        for each in (material(), soft)
    ]
    np.testing.assert_allclose(bent[1], bent[0] / (0.79 * 0.75), rtol=1e-12)


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ({"load_time": "1 h"}, "a load_time without creep"),
        ({"temperature": "50 °C"}, "a temperature without heat_deflection"),
        (
            {"temperature": "150 °C", "heat_deflection": "145 °C"},
            "a temperature above heat_deflection",
        ),
        ({"poisson": "0.4 .. 0.5"}, "poisson 0.5, out of range for an isotropic material"),
        ({"infill": "0.5 .. 1.2"}, "out of range"),
        ({"scatter": "1 .. 2 %"}, "a range a .. b is not used here"),
    ],
)
def test_a_material_that_cannot_be_is_refused(values: dict[str, Any], why: str):
    """Half a statement of creep or temperature, and ranges that leave their limits, are refused."""
    with pytest.raises(ValidationError, match=why):
        material(**values)


def test_materials_for_printing_have_ranges_with_a_source():
    """Materials of the catalogue for printed parts state what data sheets disagree on as ranges,
    each with its source, all of it assumed.
    """
    found = materials()
    onyx = found["onyx"]
    assert [each.key for each in unknown_values(onyx)] == [
        f"materials.onyx.{key}" for key in ("across_layers", "infill", "young")
    ]
    assert set(onyx.assumed) >= {"young", "across_layers", "infill"}
    for name in ("onyx", "PC-CF", "PETG-CF", "tough SLA resin", "PA12, SLS or MJF"):
        assert unknown_values(found[name]), name
        assert "[R" in found[name].source or "[M" in found[name].source
