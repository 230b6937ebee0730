"""Curves beside the scene: what they hold, and what they do not pretend to know."""

import numpy as np
import pytest
from report_run import walking

from follower_humanoid.core.samples import Wrench
from follower_humanoid.viewer.moment import Moment
from follower_humanoid.viewer.plots import PLOTS, WINDOW, Plots
from follower_humanoid.viewer.tape import Tape

LEFT = list(PLOTS).index("Force on the left hand [N]")


class Gui:
    """Takes the place of the page."""

    class Plot:
        data: tuple[np.ndarray, ...] = ()

        def _queue_update(self, name: str, value: tuple[np.ndarray, ...]) -> None:
            setattr(self, name, value)

    def __init__(self) -> None:
        self.plots: list[Gui.Plot] = []

    def add_uplot(self, *_, **__):
        self.plots.append(self.Plot())
        return self.plots[-1]


def pulled(time: float, force: float) -> Moment:
    return Moment(time, {"left_hand/applied": Wrench(np.array([force, 0.0, 0.0]), np.zeros(3))})


def show(plots: Plots) -> None:
    for plot in range(len(plots)):
        plots.show(plot)


@pytest.fixture
def gui():
    return Gui()


@pytest.fixture
def plots(gui):
    return Plots(gui)


def test_what_nobody_has_published_is_not_drawn_as_zero(gui, plots):
    plots.add(Moment(0.0))
    plots.add(pulled(0.5, 3.0))
    plots.add(pulled(1.0, 4.0))
    show(plots)
    times, x, *_ = gui.plots[LEFT].data
    np.testing.assert_array_equal(times, [0.5, 1.0])
    np.testing.assert_array_equal(x, [3.0, 4.0])


def test_curves_reach_back_as_far_as_they_say_however_seldom_somebody_looks(gui, plots):
    for time in np.arange(0.0, 3.0 * WINDOW, 0.4):
        plots.add(pulled(float(time), float(time)))
    show(plots)
    times, x, *_ = gui.plots[LEFT].data
    assert WINDOW - 0.5 < times[-1] - times[0] <= WINDOW
    np.testing.assert_array_equal(x, times)


def test_no_line_is_drawn_through_a_time_that_was_not_seen(gui, plots):
    for time in (0.0, 0.5, 7.0, 7.5):
        plots.add(pulled(time, 1.0))
    show(plots)
    np.testing.assert_array_equal(gui.plots[LEFT].data[0], [7.0, 7.5])


@pytest.mark.parametrize("path", [(2.5,), (3.0, 1.0), (0.5, 0.9, 3.0), (0.0, 0.3, 0.7, 1.6)])
def test_curves_of_a_bag_are_whole_wherever_it_is_wound_to(gui, plots, path):
    tape = Tape(walking())
    for time in path:
        plots.add(tape.moment(time), tape.moments)
    show(plots)
    weight = gui.plots[list(PLOTS).index("Weight on the feet [N]")].data
    assert weight[0][0] <= tape.begin + 0.1
    assert weight[0][-1] == path[-1]
    assert np.diff(weight[0]).max() < 0.11
    feet = [tape.run[f"{side}_foot/wrench"] for side in ("left", "right")]
    for time, *loads in zip(*weight, strict=True):
        row = round(time / tape.run.tick)
        assert loads == pytest.approx([foot.force[row][2] for foot in feet], abs=40.0)
