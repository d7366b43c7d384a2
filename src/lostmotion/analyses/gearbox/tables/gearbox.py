"""Sheet of a gearbox of any kind: ratio, hysteresis loop, and stated values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.gearbox.tables.bands import (
    bands_facts,
    bands_sections,
    first_sentence,
    stiffness_band,
    with_band,
)
from lostmotion.analyses.gearbox.tables.cycloidal import (
    cards_of_drawing,
    doubts_of_drawing,
    sections_of_drawing,
    verdict_of_drawing,
)
from lostmotion.analyses.gearbox.tables.finite_elements import (
    fem_cards,
    fem_sections,
    fem_sentences,
)
from lostmotion.analyses.gearbox.tables.friction import friction_facts
from lostmotion.analyses.gearbox.tables.loop import loop_section
from lostmotion.analyses.gearbox.tables.stated import (
    cards_of_figures,
    doubts_of_figures,
    harmonics_sections,
    load_text,
    ratio_figure,
    stated_section,
    verdict_of_figures,
    zones_sections,
)
from lostmotion.analyses.gearbox.tables.units import TURNING, units_of
from lostmotion.parts.gearbox.kinds import is_drawn
from lostmotion.reporting.provenance import with_inputs
from lostmotion.reporting.sheet import Sheet

if TYPE_CHECKING:
    from lostmotion.analyses.gearbox.gear import GearStudy
    from lostmotion.analyses.gearbox.tables.units import Units
    from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
    from lostmotion.parts.gearbox.cycloidal.examined import Drawn
    from lostmotion.parts.gearbox.cycloidal.finite_elements import FiniteElements
    from lostmotion.parts.gearbox.kinds import StatedGearbox

_WORDS: Final = (
    ("play", "free rotation of the output. A load above friction holds it on one side."),
    (
        "lost motion",
        (
            "rotation of the output between a small torque in one direction and in the other: "
            "play and elastic wind-up, without friction."
        ),
    ),
    (
        "wind-up",
        (
            "torsion of the gearbox: rotation of the output under the torque with the input held, "
            "beyond the play."
        ),
    ),
    ("displacement", "the same from the middle of the play: half the play and the wind-up."),
    (
        "secant, slope",
        (
            "stiffness without friction, from zero to the torque and between two torques. Makers "
            "state either, or others."
        ),
    ),
    (
        "loading branch",
        (
            "the curve under rising torque. Friction carries part of the torque there, so that a "
            "drive seems stiffer."
        ),
    ),
    (
        "friction's loop",
        (
            "hysteresis: with friction the angle of the output differs between rising and falling "
            "torque. Play is added to it."
        ),
    ),
    ("transmission error", "deviation of the output from the nominal ratio over a turn."),
)


def gearbox_sheet(
    name: str, study: GearStudy, notes: tuple[str, ...] = (), fem: tuple[FiniteElements, ...] = ()
) -> Sheet:
    """Return the sheet of a gearbox; `fem` are its stages by finite elements, where they were
    computed.
    """
    gearbox, drawn = study.gearbox, study.drawn
    if not is_drawn(gearbox):
        return with_inputs(_of_figures(name, study, gearbox, notes), gearbox, "gearbox")
    if drawn is None:
        raise ValueError("a gearbox by its drawing without the results of its drawing")
    return with_inputs(_of_drawing(name, study, gearbox, drawn, notes, fem), gearbox, "gearbox")


def _of_figures(
    name: str, study: GearStudy, gearbox: StatedGearbox, notes: tuple[str, ...]
) -> Sheet:
    units = units_of(gearbox)
    loop = (
        ()
        if study.loop is None or study.read is None
        else (loop_section(study.loop, study.read, study, units),)
    )
    bands = () if study.read is None else bands_sections(study.bands, study.read, units)
    stiff = None if study.read is None else stiffness_band(study.bands, study.read, units)
    return Sheet(
        name=name,
        subject="gearbox",
        verdict=first_sentence(stiff) + verdict_of_figures(study, gearbox, units),
        cards=tuple(cards_of_figures(study, gearbox, units)),
        sections=(
            stated_section(gearbox, units),
            *zones_sections(gearbox, units),
            *loop,
            *bands,
            *harmonics_sections(gearbox, units),
        ),
        notes=(*notes, *doubts_of_figures(study, gearbox, units)),
        words=_WORDS,
        source=f"{units.what}: {load_text(study, units)}",
        facts=_facts(name, study, units),
    )


def _of_drawing(
    name: str,
    study: GearStudy,
    gearbox: CycloidalGearbox,
    drawn: Drawn,
    notes: tuple[str, ...],
    fem: tuple[FiniteElements, ...],
) -> Sheet:
    units = TURNING
    load = load_text(study, units)
    geometry, lobes, built, *others = sections_of_drawing(gearbox, drawn, study.count)
    loop = () if study.loop is None else (loop_section(study.loop, drawn.read, study, units),)
    stiff = stiffness_band(study.bands, drawn.read, units)
    return Sheet(
        name=name,
        subject="gearbox",
        counts=f"{load}; {study.count} simulated gearboxes, seed {study.seed}",
        verdict=" ".join(
            [
                first_sentence(stiff) + verdict_of_drawing(gearbox, drawn, load, study.count),
                *fem_sentences(fem),
            ]
        ),
        cards=(
            *(with_band(card, stiff) for card in cards_of_drawing(gearbox, drawn, load)),
            *fem_cards(fem),
        ),
        sections=(
            geometry,
            lobes,
            *fem_sections(fem),
            built,
            *loop,
            *bands_sections(study.bands, drawn.read, units),
            *others,
        ),
        notes=(*notes, *doubts_of_drawing(gearbox, drawn, study.torque or gearbox.rated_torque)),
        words=_WORDS,
        source=(
            f"seed {study.seed}, {study.count} simulated gearboxes; torque: {load}. The same file, "
            "version, torque and seed give the same bytes."
        ),
        seed=study.seed,
        facts={
            **_facts(name, study, units),
            "seed": study.seed,
            "built": study.count,
            **friction_facts(drawn),
            "member_states": {name: str(state) for name, state in gearbox.states.items()},
        },
    )


def _facts(name: str, study: GearStudy, units: Units) -> dict[str, Any]:
    gearbox, ratio = study.gearbox, ratio_figure(study.gearbox)
    return {
        "gearbox": name,
        "kind": gearbox.kind,
        "ratio": ratio and ratio.value,
        f"{units.what}_{units.torque.replace(' ', '')}": study.torque,
        "stiffness_definition": study.read and study.read.asked.stiffness,
        **bands_facts(study.bands),
    }
