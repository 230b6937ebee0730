"""One line of the table: what, required, measured."""

from __future__ import annotations

from dataclasses import dataclass

NO_FALL = "no fall"


@dataclass(frozen=True)
class Check:
    """One line of the table.

    Attributes:
        what: What was measured.
        required: The bound, in words.
        measured: The number, in words.
        passed: Whether it holds.
    """

    what: str
    required: str
    measured: str
    passed: bool


def at_most(what: str, value: float, bound: float, unit: str = "", scale: float = 1.0) -> Check:
    """value ≤ bound, shown in `unit` after scaling."""
    return Check(what, f"≤ {bound * scale:g} {unit}", f"{value * scale:.3g} {unit}", value <= bound)


def at_least(what: str, value: float, bound: float, unit: str = "", scale: float = 1.0) -> Check:
    """value ≥ bound, shown in `unit` after scaling."""
    return Check(what, f"≥ {bound * scale:g} {unit}", f"{value * scale:.3g} {unit}", value >= bound)
