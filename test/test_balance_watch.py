"""What is told of the ZMP in the end is told of a robot that has fallen too."""

from __future__ import annotations

import numpy as np
import pytest

from follower_humanoid.balance.zmp_watch import ZmpWatch

AHEAD = np.array([1.0, 0.0])
SQUARE = np.array([[0.1, 0.1, 0.0], [-0.1, 0.1, 0.0], [-0.1, -0.1, 0.0], [0.1, -0.1, 0.0]])


def test_totals_stay_when_there_is_no_zmp_any_more():
    watch = ZmpWatch()
    assert watch.diagnostics() == {"zmp_margin [m]": "no ZMP"}
    watch.command(np.zeros(2))
    watch.see(np.array([0.03, 0.04]), SQUARE, AHEAD)
    standing = watch.diagnostics()
    watch.see(None, None, AHEAD)
    fallen = watch.diagnostics()
    assert fallen.pop("zmp_margin [m]") == "no ZMP"
    assert standing.pop("zmp_margin [m]") == pytest.approx(0.06)
    assert fallen == standing
    assert fallen["smallest_zmp_margin [m]"] == pytest.approx(0.06)
    assert fallen["zmp_error_along [m]"] == pytest.approx(0.03)
    assert fallen["zmp_error_across [m]"] == pytest.approx(0.04)
