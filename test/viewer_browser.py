"""A real Chromium without a window, driven through Selenium."""

from __future__ import annotations

import os
import shutil
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graph_bench import PATIENCE

from follower_humanoid.bench.placement import children_of

try:
    from selenium import webdriver
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.actions.action_builder import ActionBuilder
except ImportError:
    webdriver = None

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
DRIVER = shutil.which("chromedriver")

needs_browser = pytest.mark.skipif(
    webdriver is None or CHROMIUM is None or DRIVER is None,
    reason="needs selenium, chromium and chromedriver (Debian: apt install chromium chromium-driver)",
)

_FLAGS = (
    "--headless=new --no-sandbox --disable-gpu --use-gl=angle --use-angle=swiftshader"
    " --enable-unsafe-swiftshader --disable-background-networking --no-first-run --disable-component-update"
    " --disable-sync --disable-dev-shm-usage --force-device-scale-factor=1"
).split()
# Only what the viewer itself offers can be reached.
_OFFLINE = "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"

# Placement of a node in the frame `/world`, as 16 numbers column by column.
_IN_WORLD = """
const nodes = window.__viserMutable.nodeRefFromName;
const placed = (object) => { object.updateWorldMatrix(true, false); return object.matrixWorld.clone(); };
const inWorld = (matrix) => placed(nodes["/world"]).invert().multiply(matrix).elements;
"""
_COPIES = (
    _IN_WORLD
    + """
let found = null;
nodes[arguments[0]].traverse((o) => { if (typeof o.getMatrixAt === "function") found = o; });
const one = placed(found);
return Array.from({length: arguments[1]}, (_, i) => {
  found.getMatrixAt(i, one);
  return Array.from(inWorld(placed(found).multiply(one)));
});"""
)
_OPACITY = """
let found = null;
window.__viserMutable.nodeRefFromName[arguments[0]].traverse((o) => { if (o.material) found = o.material; });
return found.opacity;"""
# The library's hint that there is no graphics card would lie over the robot.
_WITHOUT_HINTS = """
const style = document.createElement("style");
style.textContent = ".mantine-Notification-root { display: none; }";
document.head.append(style);"""
_ON_SCREEN = """
const {nodeRefFromName, camera, canvas} = window.__viserMutable;
const node = nodeRefFromName[arguments[0]];
const place = node.getWorldPosition(camera.position.clone()).project(camera);
const area = canvas.getBoundingClientRect();
return [area.left + area.width * (place.x + 1) / 2, area.top + area.height * (1 - place.y) / 2];"""


_HARMLESS = "passive event listener"  # of the slider's own key handling


class Browser:
    """One window with one page."""

    def __init__(self, width: int = 940, height: int = 560) -> None:
        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        for flag in (*_FLAGS, _OFFLINE, f"--window-size={width},{height}"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver: Any = webdriver.Chrome(options, webdriver.ChromeService(DRIVER))
        self.driver.set_script_timeout(PATIENCE)

    def open(self, address: str) -> None:
        """Loads a viewer's page; returns once the robot is there."""
        self.driver.get(address)
        self.wait(lambda: self.script("return !!window.__viserMutable?.nodeRefFromName['/world/robot/box']"))
        self.script(_WITHOUT_HINTS)

    def script(self, text: str, *arguments: Any) -> Any:
        return self.driver.execute_script(text, *arguments)

    def wait(self, met: Callable[[], Any], limit: float = PATIENCE, what: str = "") -> Any:
        """Polls until something is true."""
        deadline = time.monotonic() + limit
        while not (value := met()):
            assert time.monotonic() < deadline, what or f"nothing happened; the page says: {self.text()}"
            time.sleep(0.05)
        return value

    def text(self) -> str:
        """All words on the page."""
        return str(self.script("return document.body.innerText"))

    def node(self, name: str) -> np.ndarray:
        """Placement of a scene node in `/world`, shape (4, 4)."""
        elements = self.script(_IN_WORLD + "return Array.from(inWorld(placed(nodes[arguments[0]])));", name)
        return np.array(elements).reshape(4, 4).T

    def copies(self, name: str, count: int) -> np.ndarray:
        """Placements of the copies of a batched mesh in `/world`, scales included, shape (count, 4, 4)."""
        return np.array(self.script(_COPIES, name, count)).reshape(count, 4, 4).transpose(0, 2, 1)

    def opacity(self, name: str) -> float:
        """Of the material of a scene node."""
        return float(self.script(_OPACITY, name))

    def grab(self, node: str, by: tuple[int, int], steps: int = 4) -> None:
        """Presses on a scene node and drags by so many pixels; the button stays down."""
        x, y = self.script(_ON_SCREEN, node)
        builder = ActionBuilder(self.driver, duration=40)
        pointer = builder.pointer_action
        pointer.move_to_location(round(x), round(y))
        pointer.pointer_down()
        for step in range(1, steps + 1):
            pointer.move_to_location(round(x + by[0] * step / steps), round(y + by[1] * step / steps))
        builder.perform()

    def release(self) -> None:
        ActionChains(self.driver).release().perform()

    def keys(self, *keys: str) -> None:
        ActionChains(self.driver).send_keys(*keys).perform()

    @contextmanager
    def second_window(self) -> Iterator[None]:
        """Another window of the same browser, closed at the end."""
        first = self.driver.current_window_handle
        self.driver.switch_to.new_window("window")
        try:
            yield
        finally:
            self.driver.close()
            self.driver.switch_to.window(first)

    @contextmanager
    def hanging(self) -> Iterator[None]:
        """The page does nothing at all: what draws it and runs its scripts is stopped."""
        renderers = [int(p.name) for p in _below(self.driver.service.process.pid) if _is_renderer(p)]
        assert renderers
        for pid in renderers:
            os.kill(pid, signal.SIGSTOP)
        try:
            yield
        finally:
            for pid in renderers:
                os.kill(pid, signal.SIGCONT)

    @contextmanager
    def phone(self, width: int, height: int) -> Iterator[None]:
        """The page as a phone shows it."""
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": True}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        try:
            yield
        finally:
            self.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})

    def errors(self) -> list[str]:
        """What the page has complained about on its console."""
        entries = self.driver.get_log("browser")
        return [e["message"] for e in entries if e["level"] == "SEVERE" and _HARMLESS not in e["message"]]

    def picture(self, file: Path) -> None:
        """What the window shows, as a PNG file."""
        self.driver.save_screenshot(str(file))

    def close(self) -> None:
        self.driver.quit()


def _below(ancestor: int) -> Iterator[Path]:
    """Folders in `/proc` of everything that a process and those it started have started."""
    for entry in children_of(ancestor):
        yield entry
        yield from _below(int(entry.name))


def _is_renderer(entry: Path) -> bool:
    with suppress(OSError):  # gone meanwhile
        return b"--type=renderer" in (entry / "cmdline").read_bytes()
    return False
