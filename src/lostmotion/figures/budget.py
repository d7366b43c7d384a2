"""The figures of the budget: which part is to blame, and at which level of chance."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from lostmotion.figures import Figure, Row, Section, digits, length
from lostmotion.studies.budget import costs

if TYPE_CHECKING:
    from lostmotion.studies.answer import Answer


def levels_section(answer: Answer) -> Section:
    """How much of the mean-square error comes from which level of chance, and what can be done about it?"""
    tally = answer.sampled.tally
    counted = f"exact sum over terms, {tally.poses} poses"
    names = (
        ("from load and pose", "a controller that knows the load can take it away"),
        ("from how each robot was built", "calibration can take away what of it is constant, a map of each robot the rest"),
        ("from visit to visit", "nothing takes it away"),
    )
    rows = [
        Row(
            label,
            (
                length(math.sqrt(level / tally.poses), samples=counted),
                Figure(100 * level / tally.total if tally.total else 0.0, "%", samples=counted),
            ),
            note,
        )
        for (label, note), level in zip(names, tally.levels, strict=True)
    ]
    rows.append(Row("all together", (length(math.sqrt(tally.total / tally.poses), samples=counted), Figure(100.0, "%", samples=counted))))
    left = tally.total - float(tally.levels[0])
    share = Figure(100 * left / tally.total if tally.total else 0.0, "%", samples=counted)
    rows.append(Row("left when load and pose are compensated", (length(math.sqrt(max(left, 0.0) / tally.poses), samples=counted), share)))
    return Section("levels", "What can be done about it", ("r.m.s. error", "share of mean square"), tuple(rows))


def budget_section(answer: Answer) -> Section:
    """Which part is to blame, and what would halving it buy?"""
    halving = answer.halving
    exact = f"exact sum over terms, {len(answer.poses)} poses"
    counted = f"{halving.samples} paired samples"
    rows = []
    for cost in costs(answer.sampled.tally):
        gain = halving.gains[cost.part]
        scale = 1e6
        rows.append(
            Row(
                cost.part.removeprefix("joints."),
                (
                    Figure(cost.alone * 1e6, "µm", samples=exact),
                    Figure(100 * cost.share, "%", samples=exact),
                    Figure(gain.value * scale, "µm", gain.low * scale, gain.high * scale, counted),
                ),
                "cancels part of the others" if cost.share < -5e-4 else "",  # noqa: PLR2004 - shows as -0.1 % or more
            ),
        )
    read_on = f"{digits(halving.before * 1e3)} mm on the {halving.samples} samples used for it"
    note = (
        "r.m.s. alone: all other parts ideal. Shares of the mean square add to 100 %. Halving: by how much the 95 % error falls when "
        f"this part errs half as much, its interval counting robots; read on {read_on}"
    )
    return Section("budget", "Which part is to blame", ("r.m.s. alone", "share", "halving it takes off the 95 %"), tuple(rows), note)
