"""Which part of the weight either foot may take: loads change hands gradually, a foot in the air has none."""

from __future__ import annotations

from follower_humanoid.core.samples import SIDES, ContactPlan, Side


class LoadShares:
    """Share of the weight either foot may take by plan, 0…1.

    Attributes:
        of: The share by foot.
    """

    def __init__(self) -> None:
        self.of = dict.fromkeys(SIDES, 1.0)
        self._contacts = ContactPlan(1.0, 1.0)

    def advance(
        self, leaving: Side | None, until_lift: float, swinging: Side | None, load_time: float, dt: float
    ) -> None:
        """One tick.

        Args:
            leaving: The foot that lifts off next, if one does.
            until_lift: Time until then [s].
            swinging: The foot in the air.
            load_time: Time over which a foot takes or leaves its load [s].
            dt: Tick [s].
        """
        ramp = max(load_time, dt)
        for side in SIDES:
            goal = 0.0 if side is leaving and until_lift <= ramp else 1.0
            change = min(max(goal - self.of[side], -dt / ramp), dt / ramp)
            self.of[side] = 0.0 if side is swinging else self.of[side] + change

    def contacts(self) -> ContactPlan:
        """As the balance control reads it."""
        left, right = self.of.values()
        if (left, right) != (self._contacts.left, self._contacts.right):
            self._contacts = ContactPlan(left, right)
        return self._contacts
