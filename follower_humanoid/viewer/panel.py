"""Controls on the page: pulling by sliders, pushing, resetting, and how the scene is looked at."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import viser

from follower_humanoid.core.samples import SIDES, Array, Side
from follower_humanoid.viewer.config import PullConfig
from follower_humanoid.viewer.hands import Hands

_LARGEST_IMPULSE = 40.0  # N·s
_HELP = "Drag the ball at a hand: the farther, the harder it pulls. With *Shift* also up and down."


class LeadPanel:
    """Pull, push, reset."""

    def __init__(
        self,
        gui: viser.GuiApi,
        config: PullConfig,
        hands: Hands,
        push: Callable[[Array], None],
        reset: Callable[[], None],
    ) -> None:
        """Adds the controls where the GUI's context is."""
        self._hands = hands
        self._sliders: dict[Side, list[Any]] = {}
        with gui.add_folder("Take its hand"):
            gui.add_markdown(_HELP)
            for side in SIDES:
                self._add_sliders(gui, side, config.limit)
            let_go = gui.add_button("Let go", icon=viser.Icon.HAND_OFF, hint="Key: L")
        with gui.add_folder("Push", expand_by_default=False):
            self._impulse = gui.add_slider(
                "Impulse [N·s]", min=0.0, max=_LARGEST_IMPULSE, step=1.0, initial_value=8.0
            )
            self._direction = gui.add_slider(
                "Direction [°]", min=-180.0, max=180.0, step=5.0, initial_value=90.0,
                hint="0: along x of the world, 90: to its left",
            )  # fmt: skip
            button = gui.add_button("Push the pelvis", icon=viser.Icon.WIND, hint="Key: P")
        back = gui.add_button("Back on its feet", icon=viser.Icon.REFRESH, hint="Key: R")

        def pushed(_: Any) -> None:
            angle = math.radians(self._direction.value)
            push(self._impulse.value * np.array([math.cos(angle), math.sin(angle), 0.0]))

        let_go.on_click(lambda _: self._let_go())
        button.on_click(pushed)
        back.on_click(lambda _: reset())
        gui.add_command("Let go of its hands", hotkey="L").on_trigger(lambda _: self._let_go())
        gui.add_command("Push the pelvis", hotkey="P").on_trigger(pushed)
        gui.add_command("Back on its feet", hotkey="R").on_trigger(lambda _: reset())

    def refresh(self) -> None:
        """Puts the sliders of a hand that is no longer pulled by them back to zero."""
        for side, sliders in self._sliders.items():
            if not self._hands.steady(side) and any(slider.value for slider in sliders):
                for slider in sliders:
                    slider.value = 0.0

    def _add_sliders(self, gui: viser.GuiApi, side: Side, limit: float) -> None:
        with gui.add_folder(f"{side.value.capitalize()} hand [N]", expand_by_default=side is Side.LEFT):
            self._sliders[side] = [
                gui.add_slider(name, min=-limit, max=limit, step=0.5, initial_value=0.0, hint=hint)
                for name, hint in (("x", "forward at the start"), ("y", "to its left"), ("z", "up"))
            ]
        for slider in self._sliders[side]:
            slider.on_update(lambda event, side=side: self._moved(event, side))

    def _moved(self, event: Any, side: Side) -> None:
        if event.client_id is None:  # by ourselves
            return
        force = np.array([slider.value for slider in self._sliders[side]])
        self._hands.pull_with(side, event.client_id, force, time.monotonic())

    def _let_go(self) -> None:
        self._hands.let_all_go()
        self.refresh()


class ViewPanel:
    """How the scene is looked at.

    Attributes:
        follow: Whether the robot stays in the middle of the picture.
        glass: Whether its lower legs let through what they hide.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        """Adds the controls where the GUI's context is."""
        self._server = server
        with server.gui.add_folder("View", expand_by_default=False):
            self._follow = server.gui.add_checkbox("Follow the robot", True, hint="Key: F")
            self._glass = server.gui.add_checkbox(
                "Legs of glass", True, hint="Key: G. Shows forces and points that feet and shanks hide"
            )
            self._dark = server.gui.add_checkbox("Dark", False, hint="Key: N")
        self._dark.on_update(lambda _: self._paint())
        server.gui.add_command("Follow the robot", hotkey="F").on_trigger(
            lambda _: self._toggle(self._follow)
        )
        server.gui.add_command("Legs of glass", hotkey="G").on_trigger(lambda _: self._toggle(self._glass))
        server.gui.add_command("Dark or light", hotkey="N").on_trigger(lambda _: self._toggle(self._dark))

    @property
    def follow(self) -> bool:
        """Whether the robot stays in the middle of the picture."""
        return bool(self._follow.value)

    @property
    def glass(self) -> bool:
        """Whether the robot's lower legs let through what they hide."""
        return bool(self._glass.value)

    @staticmethod
    def _toggle(box: Any) -> None:
        box.value = not box.value

    def _paint(self) -> None:
        self._server.gui.configure_theme(dark_mode=self._dark.value, show_logo=False, show_share_button=False)
