"""One gearbox: its hysteresis loop and, for a gearbox from its drawing, its members and the
profile, which is written to a DXF file.
"""

from __future__ import annotations

import math
import secrets
import tempfile
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.result import Result
from lostmotion.errors import (
    DidNotConvergeError,
    LostmotionError,
    OutputExistsError,
    refuse_argument,
)
from lostmotion.laws.perforated_disc import UnresolvedWebsError
from lostmotion.laws.torque_angle import CurveReadings, Definitions, StatedCurve, readings
from lostmotion.parts.gearbox.bands import GearBands, bands_of_figures
from lostmotion.parts.gearbox.cycloidal.examined import ExaminedDrawing, drawn
from lostmotion.parts.gearbox.cycloidal.model import LOST_MOTION
from lostmotion.parts.gearbox.kinds import is_drawn, is_gearbox
from lostmotion.reporting.folder import to_disk

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from lostmotion.laws.cycloid.finite_elements.wheel import Field
    from lostmotion.laws.torque_angle import StiffnessDefinition, TorqueAngleCurve
    from lostmotion.parts.error_source import ErrorSource
    from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
    from lostmotion.parts.gearbox.cycloidal.finite_elements import FiniteElements
    from lostmotion.parts.gearbox.kinds import AnyGearbox
    from lostmotion.reporting.figure_files import FigureKind
    from lostmotion.reporting.table_files import TableKind
    from lostmotion.spatial import Floats

# Steps of half a loop.
_STEPS: Final = 400
_ROUNDING: Final = 1e-9
# Shares of the rated torque between which most makers state the stiffness as the slope of the
# curve.
SLOPE: Final = (0.5, 1.0)


@dataclass(frozen=True)
class Loop:
    """Torque-angle hysteresis with the input held, the mean of the samples. Torques in N m, angles
    in rad (sliding drives: N and m).

    torque (step,) from the largest in one direction to the largest in the other; rising, falling
    (step,) the angles then;
    friction_rising, friction_falling the same without play: the hysteresis of friction alone. play;
    rest: the torque that traverses the play; small: the torque of the lost motion, and ends (2,)
    the middle of the loop there; None and empty where no such torque is known.
    """

    torque: Floats
    rising: Floats
    falling: Floats
    friction_rising: Floats
    friction_falling: Floats
    play: float
    rest: float
    small: float | None
    ends: Floats

    @property
    def lost_motion(self) -> float | None:
        """Return the lost motion, on the mean of the samples."""
        return float(self.ends[1] - self.ends[0]) if len(self.ends) else None

    @property
    def width(self) -> float:
        """Return the width of the loop at zero torque."""
        return float(
            np.interp(0.0, self.torque, self.falling) - np.interp(0.0, self.torque, self.rising)
        )

    @property
    def friction_width(self) -> float:
        """Return the width at zero torque of the friction loop alone."""
        return float(
            np.interp(0.0, self.torque, self.friction_falling)
            - np.interp(0.0, self.torque, self.friction_rising)
        )


@dataclass(frozen=True, repr=False)
class Gear(Result):
    """One gearbox under a torque (N m at the output; None where none is rated or stated).

    loop     None without torque, for a rigid gearbox without play, or where the torque does not
             overcome friction
    read     the data-sheet figures of every sample; None without torque
    drawn    the results from a drawing; None for gearboxes by stated figures
    bands    the figures over draws of the values that are stated as ranges; None without ranges
    dxf      an additional file for the profiles; fem: its stages by finite elements
    """

    gearbox: AnyGearbox
    torque: float | None
    count: int
    seed: int
    loop: Loop | None = None
    read: CurveReadings | None = None
    drawn: ExaminedDrawing | None = None
    bands: GearBands | None = None
    name: str = "gearbox"
    notes: tuple[str, ...] = ()
    dxf: Path | None = None
    fem: tuple[FiniteElements, ...] = ()

    @property
    def wind_up(self) -> float | None:
        """Return the mean wind-up at the torque, beyond the play."""
        return None if self.read is None else float(self.read.wind_up.mean())

    @property
    def has_drawing(self) -> bool:
        """Return whether there are profiles, and what writes them is installed."""
        from lostmotion.io.dxf import can_draw

        return self.drawn is not None and can_draw()

    def _fields(self) -> Iterable[tuple[str, Field]]:
        """Yield the fields of the meshed wheels by file name; a rigid ring has none."""
        for found in self.fem:
            first = "first-stage-" if found.name == "first stage" else ""
            yield from zip((f"{first}planet.vtu", f"{first}ring.vtu"), found.fields, strict=False)

    def files(self) -> dict[str, bytes]:
        """Return the profile of a cycloidal gearbox as profile.dxf where ezdxf is installed, and
        the fields of the finite elements as VTU files.
        """
        from lostmotion.io.vtu import vtu

        out = {"profile.dxf": self.drawing()} if self.has_drawing else {}
        for name, each in self._fields():
            fields = {
                "displacement_m": each.displacement,
                "von_mises_Pa": each.von_mises,
                "equivalent_strain": each.strain,
            }
            out[name] = vtu(each.points, each.triangles, fields)
        return out

    def report(
        self,
        out: str | Path,
        *,
        force: bool = False,
        figures: FigureKind | None = None,
        tables: TableKind | None = None,
    ) -> Path:
        """Write report.html, result.json and, for a cycloidal gearbox with ezdxf installed,
        profile.dxf into the folder `out`.

        Errors as `Result.report`, and OutputExistsError where the file `dxf` exists and `force` is
        not set.
        """
        if self.dxf is None:
            return super().report(out, force=force, figures=figures, tables=tables)
        refuse_existing_file(self.dxf, force=force)
        drawing = self.drawing()
        written = super().report(out, force=force, figures=figures, tables=tables)
        write_drawing(drawing, self.dxf, force=force)
        return written

    def further_files(self, folder: Path) -> Iterable[str]:
        """Return where the drawing is, or why there is none."""
        from lostmotion.io.dxf import CHORD_ERROR

        if self.has_drawing:
            yield (
                f"Drawing: {self.dxf or folder / 'profile.dxf'} (mm, chords within "
                f"{CHORD_ERROR * 1e6:g} µm of the profile)"
            )
        elif self.drawn is not None:
            yield "Drawing: none, ezdxf is not installed: pip install 'lostmotion[dxf]'"
        for name, _ in self._fields():
            yield f"Finite elements: {folder / name} (for ParaView; lengths in m, stresses in Pa)"

    def drawing(self) -> bytes:
        """Return the profiles as a DXF drawing; raises InputError for a gearbox by stated figures,
        LostmotionError where ezdxf is not installed.
        """
        from lostmotion.io.dxf import profile_dxf

        refuse_drawing(self.gearbox)
        return profile_dxf(self.gearbox, self.name)  # type: ignore[arg-type]


def refuse_drawing(gearbox: object) -> None:
    """Raise InputError for a gearbox that has no drawing."""
    from lostmotion.parts.gearbox.kinds import is_drawn

    if not is_drawn(gearbox):
        found = f"a gearbox of kind '{getattr(gearbox, 'kind', type(gearbox).__name__)}'"
        raise refuse_argument(
            "dxf", found, "a gearbox with a drawing, of kind 'cycloidal', or no DXF file"
        )


def gear(
    gearbox: ErrorSource,
    torque: float | None = None,
    gearboxes: int = 500,
    seed: int = 1,
    lost_motion_torque: float | None = None,
    slope_range: tuple[float, float] | None = None,
    stiffness_definition: StiffnessDefinition = "slope",
) -> Gear:
    """Study a gearbox under a torque (N m; its rated one unless stated), on this many manufactured
    samples of a drawing.

    `lost_motion_torque` N m at which the lost motion is read; default: the stated share, or 3 %, of
    the rated torque.
    `slope_range` N m between which the slope of the curve is taken; default: 50 to 100 % of the
    rated torque. Raises InputError for a definition of the stiffness without its torques;
    DidNotConvergeError where the contacts cannot carry the load.
    """
    if not is_gearbox(gearbox):
        raise refuse_argument("gearbox", type(gearbox).__name__, "a gearbox that a joint can have")
    chosen = gearbox.rated_torque if torque is None else torque
    if chosen is None:
        return Gear(gearbox, None, gearboxes, seed)
    asked = _definitions(
        gearbox, float(chosen), lost_motion_torque, slope_range, stiffness_definition
    )
    if not is_drawn(gearbox):
        curve = StatedCurve(gearbox.zones, gearbox.zone_torques, gearbox.loop_width or 0.0)
        read = readings(curve, np.array([gearbox.play.nominal]), asked)
        return Gear(
            gearbox,
            chosen,
            gearboxes,
            seed,
            _loop(curve, gearbox.play.nominal, gearbox.friction.load.nominal, read),
            read,
            None,
            bands_of_figures(gearbox, asked, seed),
        )
    inside = _drawn(gearbox, asked, gearboxes, seed)
    loop = _loop(
        inside.curve, float(inside.play.mean()), gearbox.friction_at_rest.load.nominal, inside.read
    )
    return Gear(gearbox, chosen, gearboxes, seed, loop, inside.read, inside, inside.bands)


def _drawn(
    gearbox: CycloidalGearbox, asked: Definitions, gearboxes: int, seed: int
) -> ExaminedDrawing:
    """Return the results from the drawing. Raises DidNotConvergeError, with the torque where the
    contacts cannot carry it.
    """
    try:
        return drawn(gearbox, asked, gearboxes, seed)
    except UnresolvedWebsError:
        raise
    except DidNotConvergeError as error:
        most = max(asked.levels)
        raise DidNotConvergeError(
            f"{most:.4g} N m at the output is more than the contacts of the lobes can carry: "
            "take a smaller torque, larger lobes or a stiffer "
            f"material ({error})"
        ) from error


def _definitions(
    gearbox: AnyGearbox,
    torque: float,
    small: float | None,
    slope: tuple[float, float] | None,
    stiffness: StiffnessDefinition,
) -> Definitions:
    """Return the torques asked for or by default. Raises InputError for a definition of the
    stiffness whose torques are not known.
    """
    rated = gearbox.rated_torque
    share = LOST_MOTION if is_drawn(gearbox) else gearbox.lost_motion_torque
    asked = Definitions(
        torque,
        small or (share * rated if rated is not None else None),
        slope or ((SLOPE[0] * rated, SLOPE[1] * rated) if rated is not None else None),
        stiffness,
    )
    if stiffness == "b/a" and asked.span is None:
        expected = (
            "'slope', 'secant' or 'tangent', or a torque of the lost motion below that of the load"
        )
        raise refuse_argument(
            "stiffness_definition", "'b/a'", expected, stiffness_definition="secant"
        )
    return asked


def _loop(curve: TorqueAngleCurve, play: float, rest: float, read: CurveReadings) -> Loop | None:
    """Return the hysteresis loop: wind-up, friction, and the backlash, traversed once the torque
    overcomes friction.
    """
    most, small = read.asked.torque, read.asked.small
    if most <= rest:
        return None
    past = float(np.nextafter(rest, math.inf))
    even = np.linspace(-most, most, 2 * _STEPS + 1)
    # the play is traversed between two neighbouring floating-point numbers; steps within rounding
    # of them are removed
    torque = np.unique(
        [*even[np.abs(np.abs(even) - rest) > _ROUNDING * most], -past, -rest, rest, past]
    )
    rising, falling = (each.mean(axis=1) for each in curve.branches(torque, most))
    if not (play or rising.any() or falling.any()):
        return None
    if rising[-1] >= np.interp(0.0, torque, falling):
        # when the torque reverses, friction holds the output until the torque has changed by twice
        # the friction
        falling, rising = np.minimum(falling, rising[-1]), np.maximum(rising, falling[0])
    side = play / 2
    end = None if read.lost_motion is None else float(read.lost_motion.mean()) / 2
    return Loop(
        torque=torque,
        rising=rising + np.where(torque > rest, side, -side),
        falling=falling + np.where(torque < -rest, -side, side),
        friction_rising=rising,
        friction_falling=falling,
        play=play,
        rest=rest,
        small=small,
        ends=np.array([]) if end is None else np.array([-end, end]),
    )


def refuse_existing_file(out: Path, *, force: bool) -> None:
    """Raise OutputExistsError for an existing file without `force`, a folder or a link;
    LostmotionError where the parent folder is missing.
    """
    if not out.absolute().parent.is_dir():
        raise LostmotionError(
            f"there is no folder '{out.parent}' for the drawing\n  make it, or name another "
            "file with --dxf"
        )
    if out.is_symlink() or (out.exists() and not out.is_file()):
        raise OutputExistsError(
            f"'{out}' is no file of ours to replace\n  name another file with --dxf"
        )
    if out.exists() and not force:
        raise OutputExistsError(
            f"'{out}' exists\n  replace it with --force, or name another file with --dxf"
        )
    try:
        # permissions alone do not show whether that works
        with tempfile.TemporaryFile(prefix=".lostmotion-", dir=out.absolute().parent):
            pass
    except OSError as error:
        raise LostmotionError(
            f"'{out}' could not be written: {error.strerror or error}\n  name a file that can "
            "be written with --dxf"
        ) from error


def write_drawing(drawing: bytes, out: Path, *, force: bool = False) -> Path:
    """Write the drawing into the file `out`, whole or not at all, and return its path.

    Raises OutputExistsError as `refuse_existing_file`, LostmotionError where the file cannot be
    written.
    """
    refuse_existing_file(out, force=force)
    new = out.with_name(f".{out.name[:80]}.{secrets.token_hex(4)}.new")
    try:
        new.write_bytes(drawing)
        to_disk(new)
        new.replace(out)
    except BaseException as error:
        new.unlink(missing_ok=True)
        if not isinstance(error, OSError):
            raise
        raise LostmotionError(
            f"'{out}' could not be written: {error.strerror or error}\n  name a file that can "
            "be written with --dxf"
        ) from error
    return out
