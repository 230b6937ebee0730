"""A bag on the page goes on as fast as its speed says, stops at its end, and begins anew."""

from __future__ import annotations

from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import pytest

from follower_humanoid.viewer.bag_page import SPEEDS, Transport

BEGIN, END = 2.0, 10.0


class Gui:
    """Controls by their label, without a page."""

    def __init__(self) -> None:
        self.controls: dict[str, Any] = {}

    def __getattr__(self, name: str) -> Any:
        def add(label: str, *_: Any, **options: Any) -> Any:
            if name == "add_folder":
                return nullcontext()
            control = self.controls[label] = SimpleNamespace(value=options.get("initial_value"), calls=[])
            control.on_update = control.on_click = control.on_trigger = control.calls.append
            return control

        return add

    def slide(self, label: str, value: float, person: int | None = 1) -> None:
        self.controls[label].value = value
        for call in self.controls[label].calls:
            call(SimpleNamespace(client_id=person))


@pytest.fixture
def gui() -> Gui:
    return Gui()


@pytest.fixture
def transport(gui: Gui) -> Transport:
    made = Transport(BEGIN, END)
    made.furnish(gui)  # type: ignore[arg-type]
    return made


@pytest.mark.parametrize("speed", SPEEDS)
def test_it_goes_on_as_fast_as_the_speed_says(gui: Gui, transport: Transport, speed: str) -> None:
    gui.controls["Speed"].value = speed
    transport.advance(0.5)
    assert transport.time == BEGIN  # it does not play yet
    transport.toggle()
    for _ in range(5):
        transport.advance(0.1)
    assert transport.time == pytest.approx(BEGIN + 0.5 * float(speed))


def test_another_speed_holds_from_then_on(gui: Gui, transport: Transport) -> None:
    transport.toggle()
    transport.advance(1.0)
    gui.controls["Speed"].value = "4"
    transport.advance(1.0)
    assert transport.time == pytest.approx(BEGIN + 5.0)
    transport.toggle()
    transport.advance(1.0)
    assert transport.time == pytest.approx(BEGIN + 5.0)


def test_it_stops_at_the_end_and_plays_from_the_beginning(transport: Transport) -> None:
    transport.toggle()
    transport.advance(100.0)
    assert (transport.time, transport.playing) == (END, False)
    transport.toggle()
    assert (transport.time, transport.playing) == (BEGIN, True)


def test_the_slider_moves_it_when_a_person_does_and_follows_it_otherwise(
    gui: Gui, transport: Transport
) -> None:
    gui.slide("Time [s]", 7.0)
    assert transport.time == 7.0
    gui.slide("Time [s]", 3.0, person=None)
    assert transport.time == 7.0
    transport.toggle()
    transport.advance(0.5)
    assert gui.controls["Time [s]"].value == pytest.approx(7.5)
