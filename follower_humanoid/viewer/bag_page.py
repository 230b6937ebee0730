"""A recorded run on the page: slider, play, pause, speed."""

from __future__ import annotations

import signal
import sys
import threading
import time
from pathlib import Path
from types import FrameType
from typing import Any

import viser

from follower_humanoid.bag.reader import read_run
from follower_humanoid.graph.record import Run
from follower_humanoid.viewer.config import ViewerConfig
from follower_humanoid.viewer.page import Page
from follower_humanoid.viewer.skeleton import Skeleton
from follower_humanoid.viewer.tape import Tape

SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "4", "8")
_SLIDER_EVERY = 0.1  # wall time between two steps of the slider [s]
_END = 0.05


class Transport:
    """Where in the recording the page is; people move it, time moves it.

    Attributes:
        time: What is shown [s].
        playing: Whether time goes on.
    """

    def __init__(self, begin: float, end: float) -> None:
        """Args: first and last time of the recording [s]."""
        self._begin, self._end = begin, end
        self.time, self.playing = begin, False
        self._told = 0.0

    def furnish(self, gui: viser.GuiApi) -> None:
        """Adds the controls where the GUI's context is."""
        with gui.add_folder("Recording"):
            self._slider = gui.add_slider(
                "Time [s]", min=self._begin, max=self._end, step=0.01, initial_value=self._begin
            )
            self._button = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY, hint="Key: space")
            self._speed = gui.add_dropdown("Speed", SPEEDS, initial_value="1")
        self._slider.on_update(self._slid)
        self._button.on_click(lambda _: self.toggle())
        gui.add_command("Play or pause", hotkey="space").on_trigger(lambda _: self.toggle())

    def toggle(self) -> None:
        """Plays or pauses; at the end it plays from the beginning."""
        self.playing = not self.playing
        if self.playing and self.time >= self._end - _END:
            self.time = self._begin
        self._button.label = "Pause" if self.playing else "Play"
        self._button.icon = viser.Icon.PLAYER_PAUSE if self.playing else viser.Icon.PLAYER_PLAY

    def advance(self, wall: float) -> None:
        """Lets wall time pass [s]."""
        if self.playing:
            self.time = min(self.time + wall * float(self._speed.value), self._end)
            if self.time >= self._end:
                self.toggle()
        now = time.monotonic()
        if now - self._told > _SLIDER_EVERY and abs(self._slider.value - self.time) > 0.01:
            self._told = now
            self._slider.value = round(self.time, 2)  # type: ignore[misc]

    def _slid(self, event: Any) -> None:
        if event.client_id is not None:  # by a person
            self.time = self._slider.value


class BagPage:
    """The page of a recorded run.

    Attributes:
        tape: The run, moment by moment.
        transport: Where in it the page is.
        page: What people see.
    """

    def __init__(self, run: Run, config: ViewerConfig) -> None:
        """Opens the page."""
        self.tape = Tape(run)
        self.transport = Transport(self.tape.begin, self.tape.end)
        self.page = Page(config, Skeleton(run.urdf, run.joint_names), extra=self.transport.furnish)

    def draw(self, wall: float) -> None:
        """Lets wall time pass [s], and shows what is there then."""
        self.transport.advance(wall)
        if self.page.watched:
            time = self.transport.time
            self.page.show(self.tape.moment(time), lambda _: self.tape.trail(time), self.tape.moments)


def show_bag(bag: Path, namespace: str | None, config: ViewerConfig) -> int:
    """Shows a bag until it is told to stop; returns the exit status.

    Raises:
        ConfigurationError: The bag cannot be shown.
    """
    run = read_run(bag, namespace)
    for note in run.notes:
        print(f"note: {note}", file=sys.stderr)
    shown = BagPage(run, config)
    over = threading.Event()

    def stop(number: int, frame: FrameType | None) -> None:
        over.set()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    print(f"viewer: {shown.page.address}", file=sys.stderr, flush=True)
    last = time.monotonic()
    while not over.wait(1.0 / config.rate):
        now = time.monotonic()
        shown.draw(now - last)
        last = now
    shown.page.close("The viewer was stopped.")
    return 0
