"""Ask how one bearing behaves under a load."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Final

from lostmotion.analyses.arguments import (
    JointArgument,
    ReadyArgument,
    SeedArgument,
    path_or_mapping,
)
from lostmotion.analyses.quantities import Amount
from lostmotion.analyses.result import Result
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from lostmotion.io.part_file import OnePart
    from lostmotion.loads.bearing import BearingLoad, Examined
    from lostmotion.parts.moving_joint import Bearing

# N or N m: no bearing of a robot carries more.
_MOST: Final = 1e9


def _bearing_of(name: str, value: Any, given: Mapping[str, Any]) -> OnePart[Bearing]:  # noqa: ANN401 - whatever a user passes
    from lostmotion.io.part_file import OnePart, read_bearing
    from lostmotion.parts.error_source import ErrorSource

    if isinstance(value, ErrorSource):
        return OnePart("bearing", value, ())  # type: ignore[arg-type]
    return read_bearing(path_or_mapping(name, value), given["joint"])


@question(folder="bearing")
def bearing(
    part: Annotated[
        "Bearing | str | Path | Mapping[str, Any]",
        Argument(
            "TOML with [bearing], or an arm file with `joint`. In Python also a dictionary.",
            _bearing_of,
            metavar="FILE",
        ),
    ],
    joint: JointArgument = None,
    *,
    force_radial: Annotated[
        Amount | None,
        Argument(
            "Load across the axis, '2 kN'. Default: 1 kN where no load is stated.",
            Quantity("N", "2 kN", low=-_MOST, high=_MOST),
        ),
    ] = None,
    force_axial: Annotated[
        Amount | None,
        Argument(
            "Load along the axis, '500 N'; below zero the other way.",
            Quantity("N", "500 N", low=-_MOST, high=_MOST),
        ),
    ] = None,
    moment: Annotated[
        Amount | None,
        Argument(
            "Moment in the plane of both, '30 N m'.",
            Quantity("N m", "30 N m", low=-_MOST, high=_MOST),
        ),
    ] = None,
    bearings: Annotated[
        int,
        Argument(
            "How many manufactured bearings are simulated.",
            least=1,
            most=1_000_000,
            aliases=("--built",),
        ),
    ] = 1000,
    seed: SeedArgument = 1,
    ready: ReadyArgument = None,
) -> BearingStudy:
    """Study one bearing: its clearance from delivery to work, the load on each element, the
    displacement of the shaft, its stiffness.

    Raises
    ------
    InputError
        With every mistake in the arguments and the file.

    """
    asked = read_arguments(bearing, locals())
    asked.ready()
    from lostmotion.loads.bearing import BearingLoad, examine
    from lostmotion.parts.bearing.rolling_contact import is_drawn_bearing

    one = asked.part
    stated = (asked.force_radial, asked.force_axial, asked.moment)
    assumed = all(each is None for each in stated)
    load = BearingLoad(1000.0) if assumed else BearingLoad(*(each or 0.0 for each in stated))
    notes = (*one.notes, "no load was stated: 1 kN across is assumed") if assumed else one.notes
    examined = (
        examine(one.part, load, asked.bearings, asked.seed) if is_drawn_bearing(one.part) else None
    )
    return BearingStudy(one.name, one.part, load, examined, notes)


@dataclass(frozen=True, repr=False)
class BearingStudy(Result):
    """One bearing under a load: `examined` has every number where it is described by its drawing,
    and is None where by stated values.
    """

    name: str
    part: Bearing
    load: BearingLoad
    examined: Examined | None = None
    notes: tuple[str, ...] = ()
