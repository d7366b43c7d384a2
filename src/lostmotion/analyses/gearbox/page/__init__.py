"""Page of a gearbox: its sheet and plots in reading order."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.gearbox.page.contacts import (
    branches_sections,
    friction_facts,
    friction_sections,
    geometry_section,
    lobes_section,
)
from lostmotion.analyses.gearbox.page.drawn import (
    cards_of_drawing,
    doubts_of_drawing,
    members_section,
    samples_section,
    transmission_section,
    verdict_of_drawing,
)
from lostmotion.analyses.gearbox.page.fem import fem_cards, fem_plots, fem_sections, fem_sentences
from lostmotion.analyses.gearbox.page.loop import (
    Shown,
    bands_facts,
    bands_sections,
    first_sentence,
    loop_section,
    stiffness_band,
    with_band,
)
from lostmotion.analyses.gearbox.page.plots import gearbox_plots
from lostmotion.analyses.gearbox.page.stated import (
    TURNING,
    cards_of_figures,
    doubts_of_figures,
    harmonics_sections,
    load_text,
    ratio_figure,
    stated_section,
    units_of,
    verdict_of_figures,
    zones_sections,
)
from lostmotion.parts.gearbox.kinds import is_drawn
from lostmotion.reporting.provenance import with_inputs
from lostmotion.reporting.sheet import Sheet

if TYPE_CHECKING:
    from lostmotion.analyses.gearbox.gear import Gear
    from lostmotion.analyses.gearbox.page.stated import Units
    from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
    from lostmotion.parts.gearbox.cycloidal.examined import ExaminedDrawing
    from lostmotion.parts.gearbox.kinds import StatedGearbox
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Section

__all__ = ["plots", "sheet"]
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


def sheet(gear: Gear) -> Sheet:
    """Return the sheet of a gearbox."""
    gearbox = gear.gearbox
    if not is_drawn(gearbox):
        return with_inputs(_of_figures(gear, gearbox), gearbox, "gearbox")
    if gear.drawn is None:
        raise ValueError("a gearbox by its drawing without the results of its drawing")
    return with_inputs(_of_drawing(gear, gearbox, gear.drawn), gearbox, "gearbox")


def plots(gear: Gear) -> list[Plot]:
    """Return the plots of a gearbox."""
    return [*gearbox_plots(gear), *fem_plots(gear.fem)]


def _loop(gear: Gear, units: Units) -> tuple[Section, ...]:
    """Return the tables of the hysteresis, and of what ranges leave open."""
    if gear.read is None:
        return ()
    loop = () if gear.loop is None else (loop_section(gear.loop, gear.read, gear, units),)
    return (*loop, *bands_sections(gear.bands, gear.read, Shown(gear, units)))


def _of_figures(gear: Gear, gearbox: StatedGearbox) -> Sheet:
    units = units_of(gearbox)
    stiffness = stiffness_band(gear.bands, gear.read, units)
    return Sheet(
        name=gear.name,
        subject="gearbox",
        verdict=first_sentence(stiffness) + verdict_of_figures(gear, gearbox, units),
        cards=tuple(cards_of_figures(gear, gearbox, units)),
        sections=(
            stated_section(gearbox, units),
            *zones_sections(gearbox, units),
            *_loop(gear, units),
            *harmonics_sections(gearbox, units),
        ),
        notes=(*gear.notes, *doubts_of_figures(gear, gearbox, units)),
        words=_WORDS,
        source=f"{units.what}: {load_text(gear, units)}",
        facts=_facts(gear, units),
    )


def _of_drawing(gear: Gear, gearbox: CycloidalGearbox, drawn: ExaminedDrawing) -> Sheet:
    load = load_text(gear, TURNING)
    stiffness = stiffness_band(gear.bands, drawn.read, TURNING)
    verdict = first_sentence(stiffness) + verdict_of_drawing(gearbox, drawn, load, gear.count)
    return Sheet(
        name=gear.name,
        subject="gearbox",
        counts=f"{load}; {gear.count} simulated gearboxes, seed {gear.seed}",
        verdict=" ".join([verdict, *fem_sentences(gear.fem)]),
        cards=(
            *(with_band(card, stiffness) for card in cards_of_drawing(gearbox, drawn, load)),
            *fem_cards(gear.fem),
        ),
        sections=(
            geometry_section(gearbox),
            lobes_section(gearbox, drawn),
            *fem_sections(gear.fem),
            samples_section(gearbox, drawn, gear.count),
            *_loop(gear, TURNING),
            members_section(gearbox, drawn, gear.count),
            transmission_section(drawn),
            *friction_sections(drawn),
            *branches_sections(gearbox, drawn),
        ),
        notes=(
            *gear.notes,
            *doubts_of_drawing(gearbox, drawn, gear.torque or gearbox.rated_torque),
        ),
        words=_WORDS,
        source=(
            f"seed {gear.seed}, {gear.count} simulated gearboxes; torque: {load}. The same file, "
            "version, torque and seed give the same bytes."
        ),
        seed=gear.seed,
        drawing="the profiles of disc and ring in mm" if gear.has_drawing else "",
        facts={
            **_facts(gear, TURNING),
            "seed": gear.seed,
            "built": gear.count,
            **friction_facts(drawn),
            "member_states": {name: str(state) for name, state in gearbox.states.items()},
        },
    )


def _facts(gear: Gear, units: Units) -> dict[str, Any]:
    ratio = ratio_figure(gear.gearbox)
    return {
        "gearbox": gear.name,
        "kind": gear.gearbox.kind,
        "ratio": ratio and ratio.value,
        f"{units.what}_{units.torque.replace(' ', '')}": gear.torque,
        "stiffness_definition": gear.read and gear.read.asked.stiffness,
        **bands_facts(gear.bands),
    }
