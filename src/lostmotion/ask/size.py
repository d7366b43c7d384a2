"""Size the links of an arm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lostmotion.ask.shown import Shown

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from lostmotion.arm import Arm
    from lostmotion.figures import Sheet
    from lostmotion.spatial import Floats
    from lostmotion.studies.sizing import Sizing

DEFAULT_SIZING_POSES = 1024


def size(
    arm: Arm,
    by: str | Path | None = None,
    poses: int = DEFAULT_SIZING_POSES,
    seed: int = 1,
    *,
    also: Floats | None = None,
    progress: Callable[[str, int, int], None] | None = None,
    **asked: Any,  # noqa: ANN401 - keys of a file's table
) -> Size:
    """Which sections make the links of this arm as light as their limits allow, and what would other limits cost?

    by      a TOML that says how (`formats.sizing`); left out: the paper's condition (4), each link among sections like its own
    poses   how many to look at, by a Sobol sequence; corners of the joints' ranges are looked at besides, and `also` (pose, joint), rad and m
    asked   keys of its table as in the file, slope="0.5 arcmin", deflection=2500, tilt="10 deg", family={"kind": "tube", ...}

    Raises InputError with every mistake in file and keys.
    """
    from pathlib import Path

    from lostmotion.formats.sizing import read_sizing
    from lostmotion.studies.poses import sample_poses
    from lostmotion.studies.sizing import size_links

    plan, wanted = read_sizing(None if by is None else Path(by), asked, arm)
    chosen = sample_poses(arm, poses, seed=seed)
    return Size(size_links(arm, wanted, plan.limits, chosen, tilt=plan.tilt, step=plan.step, also=also, progress=progress))


@dataclass(frozen=True)
class Size(Shown):
    """An arm whose links were sized: `summary()`, `report("out/")`, `result()`; `found.sized` is the arm, `found` holds every number."""

    found: Sizing

    @property
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""
        from lostmotion.figures.sizing import sizing_sheet

        return sizing_sheet(self.found)

    def report(self, out: str | Path, source: str | Path | None = None, sidecar: str | Path | None = None, *, force: bool = False) -> Path:
        """Write report.html and result.json into the folder `out`, whole or not at all; with the arm's `source`, where limits hold, sized.toml too.

        `source` is the file that the arm was read from, with its `sidecar` where it is a URDF whose sidecar does not lie beside it. Gives the folder.
        Raises OutputExistsError where it exists and `force` is not set.
        """
        from lostmotion.formats.sized import sized_text
        from lostmotion.report.sizing import write_sizing

        text = sized_text(source, sidecar, self.found) if source is not None and self.found.holds else None
        return write_sizing(self.sheet, self.found, text, out, force=force)
