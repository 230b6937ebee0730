"""A whole robot whose balance falls silent, as when its node is deactivated: it stays on its feet."""

from __future__ import annotations

import numpy as np
import pytest

from follower_humanoid.graph.simulate import Chain

TICK = 0.002
OF_BALANCE = ("balance/reference", "left_foot/wrench_reference", "right_foot/wrench_reference")


@pytest.mark.parametrize(("walks", "silent"), [(True, 10.5), (False, 0.0)])
def test_without_a_reference_the_robot_stands_still(tmp_path, walks, silent):
    file = tmp_path / "pull.yaml"
    file.write_text(f"- {{until: 7.0, left: [{5 * walks}, 0, 0]}}\n- {{until: 30.0}}\n")

    def balance_falls_silent(topic, tick, sample):
        return None if topic in OF_BALANCE and tick * TICK >= silent else sample

    chain = Chain({"leader": {"programme": str(file)}}, TICK, interference=balance_falls_silent)
    try:
        for _ in range(round(silent / TICK)):
            chain.advance()
        begin = chain.simulator.plant.q.copy()
        assert (begin[0] > 0.5) == walks
        for _ in range(round(3.0 / TICK)):
            chain.advance()
        state = chain.simulator.observe()
        assert chain.simulator.fall is None
        np.testing.assert_allclose(chain.simulator.plant.q[:3], begin[:3], atol=0.03)
        assert np.abs(state.odometry.linear_velocity).max() < 0.01
    finally:
        chain.close()
