"""Takes the README's pictures of the viewer from real runs: `python test/viewer_pictures.py BAG FOLDER`.

A follower is led by its hand on the page, as a person would do it; a bag is played; a phone looks at it.
"""

from __future__ import annotations

import re
import sys
import tempfile
import time
from pathlib import Path

from graph_bench import bringup, wait_until
from viewer_browser import Browser

from follower_humanoid.bag.reader import read_run
from follower_humanoid.viewer.bag_page import BagPage
from follower_humanoid.viewer.config import ViewerConfig

# Patience for a browser that draws without a graphics card.
VIEWER = """
viewer:
  ros__parameters: {port: 0, rate: 8.0, pull.patience: 30.0}
"""
_STEPS = 3
_FADE = 8.0  # the scene appears slowly where there is no graphics card [s]


def led_by_the_hand(browser: Browser, folder: Path) -> None:
    """A live robot whose left hand is dragged."""
    with tempfile.TemporaryDirectory() as work:
        (Path(work) / "viewer.yaml").write_text(VIEWER)
        arguments = "--composed --leader none --bag none --view --params viewer.yaml".split()
        with bringup(Path(work), *arguments) as run:
            run.wait_until_it_runs()
            pattern = r"viewer: (http\S+)"
            wait_until(lambda: re.search(pattern, run.complained))
            found = re.search(pattern, run.complained)
            assert found is not None, run.complained
            browser.open(found[1])
            browser.wait(lambda: "Standing" in browser.text(), 90.0)
            time.sleep(_FADE)
            while "led by the left hand" not in browser.text():
                browser.release()
                browser.grab("/world/handles/left_hand", (70, 34))
                time.sleep(3.0)
            enough = rf"half-steps\s+{_STEPS}"
            browser.wait(lambda: re.search(enough, browser.text()), 300.0)
            browser.picture(folder / "viewer_lead.png")
            browser.release()
            run.end()


def recorded(browser: Browser, bag: Path, folder: Path) -> None:
    """A recorded run in the dark, and on a phone."""
    shown = BagPage(read_run(bag), ViewerConfig(port=0))
    shown.transport.time = 0.55 * shown.tape.end

    def draw_for(seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            shown.draw(0.0)
            time.sleep(0.05)

    try:
        browser.open(shown.page.address)
        draw_for(_FADE)
        browser.keys("n")
        draw_for(4.0)
        browser.picture(folder / "viewer_bag.png")
        browser.keys("n")
        draw_for(2.0)
        with browser.phone(390, 760):
            browser.open(shown.page.address)  # as on a phone: it looks from elsewhere
            draw_for(_FADE)
            browser.picture(folder / "viewer_phone.png")
    finally:
        shown.page.close("The viewer was stopped.")


def main() -> None:
    bag, folder = (Path(word) for word in sys.argv[1:])
    folder.mkdir(parents=True, exist_ok=True)
    browser = Browser(1280, 940)
    try:
        led_by_the_hand(browser, folder)
        recorded(browser, bag, folder)
    finally:
        browser.close()


if __name__ == "__main__":
    main()
