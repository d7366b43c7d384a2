"""What was asked of the view and what is computed next: the newest pose and the newest choices
first, then the workspace bit by bit.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lostmotion.analyses.view.choices import Choices, changed
from lostmotion.analyses.view.live import Figures, LiveArm, Workspace
from lostmotion.errors import LostmotionError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


@dataclass(frozen=True)
class Refused:
    """Why choices are impossible, or why no figure can be computed; the figures before stay."""

    reason: str


class Session:
    """The state of a view. `move` and `choose` may be called by any thread; one thread calls
    `step`, which computes.
    """

    def __init__(self, arm: Arm, poses: Poses, q: Floats) -> None:
        """Begin with the arm as it is, at the pose q (joint,), rad and m; `poses` are those of the
        workspace.
        """
        self.arm = arm
        self._file, self._poses = arm, poses
        self._lock, self._news = threading.Lock(), threading.Event()
        self._q, self._choices = np.array(q, dtype=float), Choices(arm.payload.mass)
        self._moved, self._chosen = True, True
        self._live: LiveArm | None = None
        self._workspace: Iterator[Workspace | None] | None = None
        self._news.set()

    @property
    def q(self) -> Floats:
        """Return the newest pose (joint,), rad and m."""
        with self._lock:
            return self._q.copy()

    @property
    def choices(self) -> Choices:
        """Return the newest choices."""
        with self._lock:
            return self._choices

    def move(self, q: Floats) -> None:
        """Ask for another pose q (joint,), rad and m, within the joint limits; values beyond are
        moved to the limit.

        Raises ValueError for a value that is no finite number.
        """
        low, high = self._file.limits.T
        _require_finite(q)
        with self._lock:
            self._q, self._moved = np.clip(np.asarray(q, dtype=float), low, high), True
        self._news.set()

    def move_joint(self, index: int, value: float) -> None:
        """Ask for another value of one joint, rad or m, within its limits. Raises ValueError for
        one that is no finite number.
        """
        _require_finite(value)
        with self._lock:
            self._q = self._q.copy()
            self._q[index], self._moved = np.clip(value, *self._file.limits[index]), True
        self._news.set()

    def choose(self, **changes: Any) -> None:  # noqa: ANN401 - fields of Choices
        """Ask for other choices; fields that are not named stay. Raises ValueError for a payload
        that an arm file could not state.
        """
        with self._lock:
            self._choices, self._chosen = replace(self._choices, **changes), True
        self._news.set()

    def choose_gearbox(self, joint: str, name: str) -> None:
        """Ask for another gearbox of a joint, by its name in the catalogue."""
        self.choose(gearboxes={**self.choices.gearboxes, joint: name})

    def choose_section(self, joint: str, name: str) -> None:
        """Ask for another section of the link of a joint, by its name in
        `choices.section_names`.
        """
        self.choose(sections={**self.choices.sections, joint: name})

    def wait(self, seconds: float) -> None:
        """Wait until something is to be computed, at most this long."""
        if self._workspace is None:
            self._news.wait(seconds)

    def step(self) -> Figures | Workspace | Refused | None:
        """Compute what is asked for next and return it; None where nothing is complete."""
        with self._lock:
            q, choices, moved, chosen = self._q, self._choices, self._moved, self._chosen
            self._moved = self._chosen = False
            self._news.clear()
        try:
            return self._compute(q, choices, moved=moved, chosen=chosen)
        except (LostmotionError, ValueError) as error:
            return Refused(str(error))

    def _compute(
        self, q: Floats, choices: Choices, *, moved: bool, chosen: bool
    ) -> Figures | Workspace | None:
        if chosen:
            arm = changed(self._file, choices)
            live = LiveArm(arm, self._poses, choices.stage)
            found = live.figures(q)
            self.arm, self._live, self._workspace = arm, live, live.workspace()
            return found
        if moved and self._live is not None:
            return self._live.figures(q)
        if self._workspace is None:
            return None
        workspace, self._workspace = self._workspace, None  # work that fails is not repeated
        found_there = next(workspace)
        if found_there is None:
            self._workspace = workspace
        return found_there


def _require_finite(values: Floats | float) -> None:
    if not np.isfinite(values).all():
        raise ValueError("a joint value is not a finite number")
