"""One of the largest errors of a run, term by term."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lostmotion.analyses.result import Result
from lostmotion.runs.replay import Replay

if TYPE_CHECKING:
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.runs.store import Store


@dataclass(frozen=True, repr=False)
class Replayed(Replay, Result):
    """One of the largest errors of a run: `found` has its pose, draws and terms."""

    arm: str
    store: Store

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed and written."""
        from lostmotion.analyses.replay.tables import replay_sheet

        return replay_sheet(self.arm, self.store.order, self)

    @property
    def failure(self) -> str:
        """Return that the error is not reproduced, where it is not."""
        if self.reproduced:
            return ""
        return (
            "an error is not reproduced: the store holds other figures than its job makes\n  run "
            "the same `lostmotion sweep` in another folder"
        )

    def __repr__(self) -> str:
        """Return what was replayed, in a line."""
        at = self.found
        return (
            f"<Replay of design {at.design}, pose {at.pose}, robot {at.robot}, visit {at.visit}: "
            f"{at.error:.6g} m>"
        )
