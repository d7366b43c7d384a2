"""Names of the members of a cycloidal gearbox, as the error budget lists them."""

from __future__ import annotations

from typing import Final

CONTACTS: Final = "lobe contacts"
RING_PINS: Final = "ring pins"
RING_LOBES: Final = "ring lobes"
PLANET_PINS: Final = "planet pins"
DISC_BODY: Final = "disc body"
RING_BODY: Final = "ring body"
BEARING: Final = "eccentric bearing"
TILT: Final = "tilt of the discs"
BORE: Final = "seat of the eccentric bearing"
SHAFT: Final = "eccentric shaft"
SHAFT_BEARINGS: Final = "bearings of the eccentric shaft"
SHAFT_SEATS: Final = "seats of the eccentric shaft"
PINS: Final = "output pins"
SEATS: Final = "seats of the output pins"
NEEDLES: Final = "needles of the output pins"
HOLES: Final = "holes of the output pins"
PIN_MEMBERS: Final = (PINS, SEATS, NEEDLES, HOLES)
STAGE_MEMBERS: Final = (
    RING_PINS, RING_LOBES, PLANET_PINS, DISC_BODY, RING_BODY,
    BEARING, TILT, BORE, SHAFT, SHAFT_BEARINGS, SHAFT_SEATS, *PIN_MEMBERS,
)  # fmt: skip
FIRST: Final = "first stage"
FRAME: Final = "frame"
FRAME_SCREWS: Final = "frame screws"
INPUT: Final = "input shaft"
OUTSIDE: Final = (FIRST, FRAME, FRAME_SCREWS, INPUT)
# Prefix of the names of a cycloidal first stage's members.
FIRST_STAGE: Final = f"{FIRST}, "
# Ends the names of members that are only bounded.
BOUNDED: Final = " (bounded)"


def is_without_scatter(name: str) -> bool:
    """Return whether a member is a spring without scatter over gearboxes."""
    return name.endswith(BOUNDED) or name.removeprefix(FIRST_STAGE) in (*PIN_MEMBERS, *OUTSIDE)
