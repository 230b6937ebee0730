"""The page: scene, state in words, plots, and what people do on it."""

from __future__ import annotations

import io
import socket
import threading
import time
from collections.abc import Callable
from contextlib import redirect_stdout
from functools import partial
from html import escape
from typing import Any

import viser

from follower_humanoid.core.samples import SIDES, Array, Side
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.pictures.palette import DCM, FORCE, LEFT, PCM, RIGHT, ZMP
from follower_humanoid.viewer.config import ViewerConfig
from follower_humanoid.viewer.hands import Hands
from follower_humanoid.viewer.heartbeat import Heartbeat
from follower_humanoid.viewer.leash import Leashes
from follower_humanoid.viewer.moment import Moment, Trail
from follower_humanoid.viewer.panel import LeadPanel, ViewPanel
from follower_humanoid.viewer.plots import STEP, Past, Plots
from follower_humanoid.viewer.skeleton import Skeleton
from follower_humanoid.viewer.stage import Stage, place_camera, suit_camera
from follower_humanoid.viewer.telling import at_once, without_delay
from follower_humanoid.viewer.turns import Turns
from follower_humanoid.viewer.words import BAD, GOOD, WAITING, figures, state_words

# Wall times between two looks [s]
_FORCES_EVERY = 0.07
_POINTS_EVERY = 0.1
_GROUND_EVERY = 0.3
_CURVES_EVERY = 0.2
_WORDS_EVERY = 0.3
# In the light and in the dark.
_COLORS = {GOOD: ("#237032", "#69db7c"), WAITING: ("#5c6770", "#ced4da"), BAD: ("#c92a2a", "#ff8787")}
_STYLE = "".join(
    f".state-{mood} {{color: {light}}} [data-mantine-color-scheme=dark] .state-{mood} {{color: {dark}}}"
    for mood, (light, dark) in _COLORS.items()
)
_STYLE += ".sign {display: inline-block; white-space: nowrap; margin-right: .8em}"
_LEGEND = (
    ("●", "CoM", PCM),
    ("●", "ZMP", ZMP),
    ("●", "capture point", DCM),
    ("➜", "force", FORCE),
    ("━", "trail", PCM),
    ("▭", "left foot", LEFT),
    ("▭", "right foot", RIGHT),
)


class Page:
    """What is offered at one address.

    Attributes:
        hands: Who holds the robot's hands.
        push: Called with an impulse [N·s] when somebody pushes; None: no such button.
        reset: Called when somebody wants the robot back on its feet.
    """

    def __init__(
        self,
        config: ViewerConfig,
        skeleton: Skeleton,
        push: Callable[[Array], None] | None = None,
        reset: Callable[[], None] | None = None,
        extra: Callable[[viser.GuiApi], None] | None = None,
    ) -> None:
        """Opens the page.

        Args:
            config: Where, and how hard people may pull.
            skeleton: The robot.
            push, reset: What to do with the buttons of a live robot; None for a recorded one.
            extra: Adds its own controls below the state.
        """
        _check_address(config.host)
        with redirect_stdout(io.StringIO()):  # viser announces itself; one line of ours is enough
            self._server = viser.ViserServer(config.host, config.port, verbose=False)
        without_delay(self._server)
        self._config = config
        self.hands = Hands(config.pull)
        self._lock = threading.Lock()
        self._furnish()
        self._stage = Stage(self._server.scene, skeleton)
        self._state = self._server.gui.add_html("")
        if extra is not None:
            extra(self._server.gui)
        self._lead: LeadPanel | None = None
        self._leashes: Leashes | None = None
        if push is not None and reset is not None:
            self._leashes = Leashes(self._server, self._stage, self.hands)
            self._lead = LeadPanel(self._server.gui, config.pull, self.hands, push, reset)
        self._view = ViewPanel(self._server)
        plots = self._server.gui.add_panel()
        with plots.add_tab("Curves", viser.Icon.CHART_LINE):
            self._plots = Plots(self._server.gui, () if push else ("Real-time factor",))
        plots.dock_left()
        plots.set_width(300)
        self._words = ""
        self._turns = self._take_turns()
        self._server.on_client_connect(suit_camera)
        self._server.on_client_disconnect(self._gone)
        self._heartbeat = Heartbeat(self.hands, self._server.get_clients, config.pull.patience)

    @property
    def address(self) -> str:
        """Where the page is."""
        host = self._server.get_host()
        shown = "127.0.0.1" if host in ("0.0.0.0", "::") else host
        return f"http://{shown}:{self._server.get_port()}"

    @property
    def watched(self) -> bool:
        """Whether anybody has the page open."""
        return bool(self._server.get_clients())

    def show(self, moment: Moment, trail: Callable[[Moment], Trail], past: Past | None = None) -> None:
        """Draws a moment: the robot, and of the rest what is due.

        Args:
            moment: What is seen.
            trail: What lies on the ground at a moment; asked for less often than moments are drawn.
            past: What was there before, where that is known.
        """
        self._trail, self._past = trail, past
        with at_once(self._server):
            self._stage.show_through(self._view.glass)
            self._stage.draw_robot(moment, self._view.follow)
            if self._leashes is not None:
                self._leashes.draw()
            self._turns.take(moment)

    def forces(self) -> dict[Side, Array | None]:
        """What people do to the hands now [N]; None where nobody holds on."""
        now = time.monotonic()
        return {side: self.hands.force(side, self.hand(side), now) for side in SIDES}

    def hand(self, side: Side) -> Array:
        """Where a hand is in the picture, shape (3,) [m]."""
        return self._stage.skeleton.position(f"{side.prefix}_gripper") + self._stage.offset

    def close(self, words: str) -> None:
        """Says a last word and goes; pages keep it."""
        self._heartbeat.end()
        self.hands.let_all_go()
        self._write(WAITING, words, [])
        self._server.flush()
        time.sleep(0.3)  # a word that is on its way arrives
        with redirect_stdout(io.StringIO()):
            self._server.stop()

    def _furnish(self) -> None:
        server = self._server
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.gui.set_panel_label("Follower")
        server.gui.main_panel.dock_right()
        server.scene.configure_default_lights(cast_shadow=self._config.shadows)
        place_camera(server)

    def _take_turns(self) -> Turns:
        turns = Turns(self._config.rate)
        turns.add(_POINTS_EVERY, self._stage.draw_points)
        turns.add(_FORCES_EVERY, self._stage.draw_forces)
        turns.add(_GROUND_EVERY, lambda moment: self._stage.draw_footprints(moment, self._trail(moment)))
        turns.add(_WORDS_EVERY, self._say)
        turns.add(STEP, lambda moment: self._plots.add(moment, self._past))
        for plot in range(len(self._plots)):
            turns.add(_CURVES_EVERY, partial(self._draw_plot, plot))
        return turns

    def _draw_plot(self, plot: int, _: Moment) -> None:
        self._plots.show(plot)

    def _say(self, moment: Moment) -> None:
        if self._lead is not None:
            self._lead.refresh()
        self._write(*state_words(moment), figures(moment) if moment.has_robot else [])

    def _write(self, mood: str, words: str, rows: list[tuple[str, str]]) -> None:
        cells = "".join(
            f'<tr><td style="opacity:.7">{escape(name)}</td>'
            f'<td style="text-align:right;font-variant-numeric:tabular-nums">{escape(value)}</td></tr>'
            for name, value in rows
        )
        dots = "".join(
            f'<span class="sign"><span style="color:{color}">{sign}</span> {name}</span>'
            for sign, name, color in _LEGEND
        )
        text = (
            f'<style>{_STYLE}</style><div role="status" style="padding:.2em .8em .5em;font-size:.86em">'
            f'<div class="state-{mood}" style="font-weight:600;font-size:1.15em">{escape(words)}</div>'
            f'<table style="width:100%;border-spacing:0;margin:.3em 0">{cells}</table>'
            f'<div style="font-size:.92em">{dots}</div></div>'
        )
        if text != self._words:
            self._words = text
            self._state.content = text

    def _gone(self, client: Any) -> None:
        self.hands.gone(client.client_id)


def _check_address(host: str) -> None:
    """Whether a server can be reached there: viser itself would try forever.

    Raises:
        ConfigurationError: Not an address of this machine.
    """
    try:
        family = socket.getaddrinfo(host, 0, type=socket.SOCK_STREAM)[0][0]
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.bind((host, 0))
    except OSError as error:
        raise ConfigurationError(
            f"viewer: host '{host}': {error.strerror}; valid: 127.0.0.1, 0.0.0.0"
        ) from None
