"""Look at one gearbox."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lostmotion.analyses.arguments import a_path
from lostmotion.analyses.quantities import amount
from lostmotion.analyses.result import Shown
from lostmotion.errors import Mistakes, refuse_argument
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.analyses.gearbox.gear import GearStudy
    from lostmotion.analyses.quantities import Amount
    from lostmotion.io.part_file import OnePart
    from lostmotion.parts.error_source import ErrorSource
    from lostmotion.reporting.sheet import Sheet

DEFAULT_GEARBOXES = 1000
# N m, or N: no robot's joint has more.
_MOST = 1e9


def gear(
    path: str | Path,
    joint: str | None = None,
    torque: Amount | None = None,
    gearboxes: int = DEFAULT_GEARBOXES,
    seed: int = 1,
    lost_motion_torque: Amount | None = None,
    slope_range: tuple[Amount, Amount] | None = None,
) -> Gear:
    """Study the gearbox in this file: play, lost motion, stiffness and compliance by member, hysteresis, transmission error.

    path      a file about a gearbox, or an arm with the `joint` whose gearbox is meant
    torque    at the output, "200 N m", or "500 N" for a drive that slides; left out: the rated one
    gearboxes how many samples of a drawing are simulated
    seed      same seed, same bits
    lost_motion_torque  at which lost motion is read, "4 %" of the rated torque or "12 N m"; left out: as stated, or 3 %
    slope_range         between which torques the slope of the stiffness is taken, ("50 %", "100 %"), which is the default, or ("10 N m", "40 N m")

    Raises InputError with every mistake in the file, and as `studies.gearbox.gear.gear`.
    """
    from lostmotion.io.part_file import read_gearbox

    found = read_gearbox(a_path("path", path), joint)
    return look_at(found, ("torque", "lost_motion_torque", "slope_range"), torque, lost_motion_torque, slope_range, gearboxes, seed)


def look_at(
    found: OnePart[ErrorSource],
    names: tuple[str, str, str],
    torque: Amount | None,
    lost_motion_torque: Amount | None,
    slope_range: tuple[Amount, Amount] | None,
    gearboxes: int,
    seed: int,
) -> Gear:
    """Study a gearbox that was read; `names` are those of the three arguments for messages."""
    from lostmotion.analyses.gearbox.gear import gear as study

    with Mistakes() as mistakes:
        asked = None if torque is None else mistakes.of(amount, names[0], torque, torque_of(found.part))
        small = None if lost_motion_torque is None else mistakes.of(_of_rated, names[1], lost_motion_torque, found.part)
        slope = None if slope_range is None else mistakes.of(_slope, names[2], slope_range, found.part)
    return Gear(found.name, found.notes, study(found.part, asked, gearboxes, seed, small, slope))


def _slope(name: str, stated: tuple[Amount, Amount], gearbox: ErrorSource) -> tuple[float, float]:
    if isinstance(stated, str) or len(stated) != 2:  # noqa: PLR2004 - from one to the other
        raise refuse_argument(name, stated, "two torques, or shares of the rated one", f'{name} = ("50 %", "100 %")')
    low, high = (_of_rated(name, each, gearbox, from_zero=k == 0) for k, each in enumerate(stated))
    if low >= high:
        found = " to ".join(map(str, stated))
        raise refuse_argument(name, found, "two rising torques, or shares of the rated one", f"{name} '50 %' '100 %'")
    return low, high


def _of_rated(name: str, value: Amount, gearbox: ErrorSource, *, from_zero: bool = False) -> float:
    """Return a torque stated as such, or as a share of the rated torque in per cent, N m; zero only where asked for."""
    wanted = torque_of(gearbox, from_zero=from_zero)
    if not (isinstance(value, str) and value.strip().endswith("%")):
        return amount(name, value, wanted)
    share = amount(name, value, Quantity("", "50 %" if from_zero else "3 %", low=0, above=-1 if from_zero else 0, high=2.5))
    rated = getattr(gearbox, "rated_torque", None)
    if rated is None:
        raise refuse_argument(name, value, "a torque, for this gearbox states no rated_torque to take a share of", f'{name} "{wanted.example}"')
    return float(share * rated)


def torque_of(gearbox: ErrorSource, *, from_zero: bool = False) -> Quantity:
    """What may be asked of this gearbox at its output: a torque, or of a drive that slides a force?"""
    from lostmotion.analyses.gearbox.tables.gearbox import units_of

    si = units_of(gearbox).torque
    example = "200 N m" if si == "N m" else "500 N"
    return Quantity(si, example, low=0, high=_MOST) if from_zero else Quantity(si, example, above=0, high=_MOST)


@dataclass(frozen=True)
class Gear(Shown):
    """One gearbox that was looked at: `summary()`, `report("out/")`, `result()`, `drawing()`; `study` holds every number."""

    name: str
    notes: tuple[str, ...]
    study: GearStudy

    @property
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""
        from lostmotion.analyses.gearbox.tables.gearbox import gearbox_sheet

        return gearbox_sheet(self.name, self.study, self.notes)

    def report(self, out: str | Path, *, force: bool = False) -> Path:
        """Write report.html, result.json and, for a cycloidal gearbox with ezdxf installed, profile.dxf into the folder `out`, whole or not at all.

        Gives the folder. Raises OutputExistsError where it exists and `force` is not set.
        """
        from lostmotion.analyses.gearbox.report import write_gearbox
        from lostmotion.io.dxf import can_draw

        drawing = self.drawing() if self.study.drawn is not None and can_draw() else None
        return write_gearbox(self.sheet, self.study, drawing, out, force=force)

    def drawing(self) -> bytes:
        """Give the profiles as a DXF drawing; raises InputError for a gearbox by stated figures, LostmotionError where ezdxf is not installed."""
        from lostmotion.io.dxf import profile_dxf
        from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox

        gearbox = self.study.gearbox
        if not isinstance(gearbox, CycloidalGearbox):
            raise refuse_argument("dxf", f"a gearbox of kind '{gearbox.kind}'", "one by its drawing, of kind 'cycloidal'", "--dxf left out")
        return profile_dxf(gearbox, self.name)
