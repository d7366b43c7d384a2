"""Ask how one gearbox behaves."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

from lostmotion.analyses.arguments import (
    JointArgument,
    ProgressArgument,
    ReadyArgument,
    SeedArgument,
    path_of,
    path_or_mapping,
)
from lostmotion.analyses.quantities import Amount, amount
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.errors import refuse_argument
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from lostmotion.analyses.gearbox.gear import Gear
    from lostmotion.io.part_file import OnePart
    from lostmotion.parts.error_source import ErrorSource
    from lostmotion.parts.gearbox.cycloidal.finite_elements import FiniteElements

# N m, or N: no robot's joint has more.
_MOST = 1e9
_MOST_GEARBOXES = 100_000


def _gearbox_of(name: str, value: Any, given: Mapping[str, Any]) -> OnePart[ErrorSource]:  # noqa: ANN401 - whatever a user passes
    from lostmotion.io.part_file import OnePart, read_gearbox
    from lostmotion.parts.gearbox.kinds import is_gearbox

    if is_gearbox(value):
        return OnePart(value.model or "gearbox", value, ())  # type: ignore[arg-type]
    return read_gearbox(path_or_mapping(name, value), given["joint"])


def _torque(name: str, value: Any, given: Mapping[str, Any]) -> Any:  # noqa: ANN401 - whatever a user passes
    part = getattr(given["part"], "part", None)  # None: its own mistakes are reported already
    return value if part is None else amount(name, value, torque_of(part))


def _small_torque(name: str, value: Any, given: Mapping[str, Any]) -> Any:  # noqa: ANN401 - whatever a user passes
    part = getattr(given["part"], "part", None)
    return value if part is None else _of_rated(name, value, part)


def _slope(name: str, value: Any, given: Mapping[str, Any]) -> Any:  # noqa: ANN401 - whatever a user passes
    part = getattr(given["part"], "part", None)
    if part is None:
        return value
    if isinstance(value, str) or len(value) != 2:  # noqa: PLR2004 - from one to the other
        raise refuse_argument(
            name, value, "two torques, or shares of the rated one", **{name: ("50 %", "100 %")}
        )
    low, high = (_of_rated(name, each, part, from_zero=k == 0) for k, each in enumerate(value))
    if low >= high:
        found = " to ".join(map(str, value))
        raise refuse_argument(
            name,
            found,
            "two rising torques, or shares of the rated one",
            **{name: ("50 %", "100 %")},
        )
    return low, high


def _of_rated(name: str, value: Amount, gearbox: ErrorSource, *, from_zero: bool = False) -> float:
    """Return a torque stated as such, or as a share of the rated torque in per cent, N m; zero only
    where asked for.
    """
    wanted = torque_of(gearbox, from_zero=from_zero)
    if not (isinstance(value, str) and value.strip().endswith("%")):
        return amount(name, value, wanted)
    share = amount(
        name,
        value,
        Quantity("", "50 %" if from_zero else "3 %", low=0, above=-1 if from_zero else 0, high=2.5),
    )
    rated = getattr(gearbox, "rated_torque", None)
    if rated is None:
        expected = "a torque, for this gearbox states no rated_torque to take a share of"
        raise refuse_argument(name, value, expected, **{name: wanted.example})
    return float(share * rated)


def torque_of(gearbox: ErrorSource, *, from_zero: bool = False) -> Quantity:
    """Return what may be asked of this gearbox at its output: a torque, or of a drive that slides a
    force.
    """
    from lostmotion.analyses.gearbox.page.stated import units_of

    si = units_of(gearbox).torque
    example = "200 N m" if si == "N m" else "500 N"
    return (
        Quantity(si, example, low=0, high=_MOST)
        if from_zero
        else Quantity(si, example, above=0, high=_MOST)
    )


@question(folder="gearbox")
def gear(
    part: Annotated[
        "ErrorSource | str | Path | Mapping[str, Any]",
        Argument(
            "TOML with [gearbox], or an arm file with `joint`. In Python also a dictionary.",
            _gearbox_of,
            metavar="FILE",
        ),
    ],
    joint: JointArgument = None,
    *,
    torque: Annotated[
        Amount | None,
        Argument(
            (
                "Torque at the output, '200 N m'; '500 N' for a drive that slides. Default: the "
                "rated one."
            ),
            _torque,
            metavar="TORQUE",
        ),
    ] = None,
    lost_motion_torque: Annotated[
        Amount | None,
        Argument(
            (
                "Lost motion is read at ± this torque: '4 %' of the rated one, or '12 N m'. "
                "Default: as stated, or 3 %."
            ),
            _small_torque,
            metavar="TORQUE",
        ),
    ] = None,
    slope_range: Annotated[
        "tuple[Amount, Amount] | None",
        Argument(
            (
                "Torques between which the stiffness is a slope. Default: '50 %' '100 %' of the "
                "rated one."
            ),
            _slope,
            metavar="TORQUE",
            together=2,
        ),
    ] = None,
    stiffness_definition: Annotated[
        Literal["slope", "b/a", "secant", "tangent"],
        Argument(
            "Definition of the stiffness: 'slope' over the slope range, 'b/a' from the lost "
            "motion's torque to the load, 'secant', 'tangent'."
        ),
    ] = "slope",
    gearboxes: Annotated[
        int,
        Argument(
            "How many manufactured samples of a drawing are simulated.",
            least=2,
            most=_MOST_GEARBOXES,
        ),
    ] = 500,
    seed: SeedArgument = 1,
    dxf: Annotated[
        "str | Path | None",
        Argument(
            "DXF file that the report writes the profiles to as well (cycloidal; needs ezdxf).",
            path_of,
            metavar="DXF",
        ),
    ] = None,
    fem: Annotated[
        bool,
        Argument(
            "Also solve the contact by finite elements: rotation, pressure, stresses "
            "(cycloidal; needs ngsolve)."
        ),
    ] = False,
    fem_3d: Annotated[
        bool, Argument("As `fem`, and the rotation in three dimensions too, coarsely.")
    ] = False,
    fem_order: Annotated[
        int | None,
        Argument("As `fem`, with finite elements of this order. Default: 2.", least=2, most=4),
    ] = None,
    fem_refinement: Annotated[
        int | None,
        Argument("As `fem`, with elements this many times smaller. Default: 1.", least=1, most=4),
    ] = None,
    progress: ProgressArgument = None,
    ready: ReadyArgument = None,
) -> Gear:
    """Study one gearbox: play and lost motion, stiffness and compliance by member, hysteresis, lobe
    loads, transmission error, profile.

    Raises
    ------
    InputError
        With every mistake in the arguments and the file.

    """
    asked = read_arguments(gear, locals())
    from lostmotion.analyses.gearbox.gear import gear as study
    from lostmotion.analyses.gearbox.gear import refuse_drawing

    one = asked.part
    if asked.dxf is not None:
        refuse_drawing(one.part)
    by_fem = (
        asked.fem or asked.fem_3d or asked.fem_order is not None or asked.fem_refinement is not None
    )
    if by_fem:
        from lostmotion.parts.gearbox.cycloidal.finite_elements import check_fem

        check_fem(one.part)
    asked.ready()
    found = study(
        one.part,
        asked.torque,
        asked.gearboxes,
        asked.seed,
        asked.lost_motion_torque,
        asked.slope_range,
        asked.stiffness_definition,
    )
    by_elements: tuple[FiniteElements, ...] = ()
    if by_fem and found.torque is not None:
        from lostmotion.parts.gearbox.cycloidal.finite_elements import (
            Mesh,
            check_fem,
            finite_elements,
        )

        mesh = Mesh(asked.fem_order or 2, asked.fem_refinement or 1, three_dimensions=asked.fem_3d)
        by_elements = finite_elements(check_fem(one.part), found.torque, mesh, progress)
    return replace(found, name=one.name, notes=one.notes, dxf=asked.dxf, fem=by_elements)
