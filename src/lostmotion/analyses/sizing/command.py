"""Size the links of an arm by limits, or choose its parts for a target on the tool."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.result import Shown
from lostmotion.error_model.provenance import refuse_undescribed, states
from lostmotion.errors import refuse_argument
from lostmotion.propagation.first_order import refuse_large_errors

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from lostmotion.analyses.sizing.sizing import Sizing
    from lostmotion.analyses.sizing.target_study import Aimed
    from lostmotion.catalogue.gearboxes import GearboxRow
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.spatial import Floats

DEFAULT_SIZING_POSES = 1024
# With a target: poses that the search sums up at; the full study of what it found has as many as a study of an arm.
DEFAULT_SEARCH_POSES = 128
# Keys of the table that are amounts with a unit.
_UNITS: Final = {"slope": "rad", "tilt": "rad", "step": "m", "target": "m"}


def size(  # noqa: PLR0913 - a sizing is these
    arm: Arm,
    by: str | Path | None = None,
    poses: int | None = None,
    seed: int = 1,
    *,
    also: Floats | None = None,
    reducers: Sequence[GearboxRow] = (),
    threads: int | None = None,
    progress: Callable[[str, int, int], None] | None = None,
    **asked: Any,  # noqa: ANN401 - keys of a file's table
) -> Size | Selection:
    """Which sections make the links of this arm as light as their limits allow? Or, with a target: which parts hold it at the least cost?

    by       a TOML that says how (`formats.sizing`); left out: the paper's condition (4), each link among sections like its own
    poses    how many to look at, by a Sobol sequence: 1024, or 128 in the search for a target, which a full study of 2048 follows; corners of the
             joints' ranges are looked at besides, and by limits `also` (pose, joint), rad and m
    asked    keys of its table as in the file, slope="0.5 arcmin", deflection=2500, tilt="10 deg", family={"kind": "tube", ...}, target="0.5 mm";
             amounts are text with a unit, or numbers in SI, a range of sizes ("30 mm", 0.2) or "30 mm .. 200 mm"
    reducers rows of the user's own that the file may name besides the catalogue's (`formats.own_reducers.read_reducers`)
    threads  of the full study; left out: one per processor

    Raises InputError with every mistake in file and keys.
    """
    import os

    from lostmotion.analyses.arguments import DEFAULT_POSES, DEFAULT_ROBOTS, DEFAULT_VISITS, a_path, an_arm
    from lostmotion.analyses.sizing.request import read_asked
    from lostmotion.error_model.poses import sample_poses

    arm = an_arm(arm)
    if asked.get("target") is not None:
        refuse_undescribed(arm)  # before what the links lack: without errors there is nothing to keep a target
        refuse_large_errors(arm)
    in_words = {name: _worded(name, value) for name, value in asked.items()}
    said = read_asked(None if by is None else a_path("by", by), in_words, arm, reducers)
    if said.plan.target is None:
        from lostmotion.analyses.sizing.sizing import size_links

        chosen = sample_poses(arm, DEFAULT_SIZING_POSES if poses is None else poses, seed=seed)
        return Size(size_links(arm, said.wanted, said.plan.limits, chosen, tilt=said.plan.tilt, step=said.plan.step, also=also, progress=progress))
    if also is not None:
        raise refuse_argument("also", "poses given", "no poses beside a target, which is over the workspace", "also left out")
    from lostmotion.analyses.sizing.target_study import Counts, aim

    refuse_undescribed(arm)
    refuse_large_errors(arm)
    found = aim(
        arm,
        said.slots,
        said.worth,
        said.plan.target,
        sample_poses(arm, DEFAULT_SEARCH_POSES if poses is None else poses, seed=seed),
        sample_poses(arm, DEFAULT_POSES, seed=seed),
        rules=said.rules,
        counts=Counts(DEFAULT_ROBOTS, DEFAULT_VISITS, seed, threads or os.cpu_count() or 1),
        progress=progress,
    )
    return Selection(found, said.notes)


def _worded(name: str, value: Any) -> Any:  # noqa: ANN401 - values of a file's table
    """Give numbers in SI as text with their unit, as the table has them; anything else as it is."""
    if name in _UNITS:
        return f"{float(value)!r} {_UNITS[name]}" if _is_number(value) else value
    if name == "family" and isinstance(value, dict):
        return {size: _size(each) for size, each in value.items()}
    if name == "stock" and isinstance(value, list | tuple):
        return [_worded("family", each) for each in value]
    if name == "links" and isinstance(value, dict):
        return {joint: {key: _worded(key, each) for key, each in said.items()} if isinstance(said, dict) else said for joint, said in value.items()}
    return value


def _size(value: Any) -> Any:  # noqa: ANN401 - a size, or a range of it
    if _is_number(value):
        return f"{float(value)!r} m"
    return " .. ".join(str(_size(each)) for each in value) if isinstance(value, tuple) else value


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


@dataclass(frozen=True)
class Size(Shown):
    """An arm whose links were sized: `summary()`, `report("out/")`, `result()`; `found.sized` is the arm, `found` holds every number."""

    found: Sizing

    @property
    def states(self) -> States:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values of the sized arm."""
        return states(self.found.sized)

    @property
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""
        from lostmotion.analyses.sizing.tables.sizing import sizing_sheet

        return sizing_sheet(self.found)

    def report(self, out: str | Path, source: str | Path | None = None, sidecar: str | Path | None = None, *, force: bool = False) -> Path:
        """Write report.html and result.json into the folder `out`, whole or not at all; with the arm's `source`, where limits hold, sized.toml too.

        `source` is the file that the arm was read from, with its `sidecar` where it is a URDF whose sidecar does not lie beside it. Gives the folder.
        Raises OutputExistsError where it exists and `force` is not set.
        """
        from lostmotion.analyses.sizing.arm_writer import sized_text
        from lostmotion.analyses.sizing.report import write_sizing

        text = sized_text(source, sidecar, self.found) if source is not None and self.found.holds else None
        return write_sizing(self.sheet, self.found, text, out, force=force)


@dataclass(frozen=True)
class Selection(Shown):
    """An arm whose parts were chosen for a target: `summary()`, `report("out/")`, `result()`; `found.sized` is the arm, `found` every number."""

    found: Aimed
    notes: tuple[str, ...] = ()

    @property
    def states(self) -> States:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values of the sized arm."""
        return states(self.found.sized)

    @property
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""
        from lostmotion.analyses.sizing.tables.selection import aimed_sheet

        return aimed_sheet(self.found, self.notes)

    def report(self, out: str | Path, source: str | Path | None = None, sidecar: str | Path | None = None, *, force: bool = False) -> Path:
        """Write report.html and result.json into the folder `out`, whole or not at all; with `source`, where the target holds, sized.toml too.

        Arguments and errors as `Size.report`.
        """
        from lostmotion.analyses.sizing.arm_writer import sized_text
        from lostmotion.analyses.sizing.report import write_aimed

        text = sized_text(source, sidecar, self.found) if source is not None and self.found.holds else None
        return write_aimed(self.sheet, self.found, text, out, force=force)
