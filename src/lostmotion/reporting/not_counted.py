"""What comparisons of designs do not count."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterable

# No command that compares designs computes any of these: all of them look at the arm at rest and
# new.
NOT_COUNTED: Final = (
    "motion (acceleration torques, vibration, servo errors), motors, thermal expansion where no "
    "temperature is stated, wear and life, collisions"
)


def without_mass(models: Iterable[str]) -> str:
    """Return the clause that names models whose mass nobody stated; empty without any."""
    named = ", ".join(dict.fromkeys(models))
    return f", mass of {named} (not stated: counted as zero)" if named else ""
