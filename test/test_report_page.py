"""The HTML page carries everything it shows, and shows what was recorded."""

from __future__ import annotations

import dataclasses
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from report_run import walking
from viewer_browser import Browser, needs_browser

from follower_humanoid.errors import ConfigurationError
from follower_humanoid.graph.record import Run
from follower_humanoid.pictures.page import write_page
from follower_humanoid.pictures.shapes import visual_shapes
from follower_humanoid.pictures.style import views
from follower_humanoid.robot.model import RobotModel


@pytest.fixture(scope="module")
def run() -> Run:
    return walking()


class Page(HTMLParser):
    """What a page refers to and which elements it leaves open."""

    VOID = frozenset({"meta", "img", "input", "br", "link"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.references: list[str] = []
        self.within: list[str] = []
        self.titles: list[str] = []
        self.open: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.references += [value or "" for name, value in attrs if name in ("src", "href")]
        if tag == "iframe":
            told = dict(attrs)
            self.within.append(told["srcdoc"] or "")
            self.titles.append(told["title"] or "")
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert tag in self.VOID or self.open.pop() == tag


def page_of(run: Run, path: Path, label: str = "walk") -> str:
    picture = path.with_name("picture.png")
    picture.write_bytes(b"\x89PNG")
    write_page(path, views([(label, run)]), [("Picture", picture)], ["a note & more"])
    return path.read_text(encoding="utf-8")


def test_nothing_is_fetched_from_elsewhere(run: Run, tmp_path: Path) -> None:
    page = Page(page_of(run, tmp_path / "page.html"))
    assert page.open == []
    assert page.references
    assert all(reference.startswith("data:image/png;base64,") for reference in page.references)
    (within,) = page.within
    assert all(reference.startswith("data:") for reference in Page(within).references)


def test_names_cannot_break_out(run: Run, tmp_path: Path) -> None:
    evil = '"></iframe><script>alert(1)</script>'
    told = dataclasses.replace(run, about={"command": evil})
    text = page_of(told, tmp_path / "page.html", evil)
    assert "alert(1)</script>" not in text
    page = Page(text)
    assert page.open == []
    assert page.titles == [f"{evil} in 3D"]


@needs_browser
def test_the_run_plays_in_a_browser_without_a_server(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    page_of(run, path)
    browser = Browser(420, 360)
    try:
        browser.driver.get(path.as_uri())
        browser.driver.switch_to.frame(0)
        browser.wait(lambda: browser.script("return !!window.__viserMutable?.nodeRefFromName['/world']"))
        moved = "return window.__viserMutable.nodePoseData['/world']?.position[0] ?? 0"
        browser.wait(lambda: browser.script(moved) < -0.2)  # the picture follows the robot
        assert browser.errors() == []
    finally:
        browser.close()


def test_every_visual_of_the_robot_is_shown() -> None:
    urdf = RobotModel().urdf
    shapes = visual_shapes(urdf)
    assert len(shapes) == urdf.count("<visual>")
    assert {shape.kind for shape in shapes} == {"box", "cylinder", "sphere"}
    assert all(max(shape.size) > 0 for shape in shapes)


def test_origins_turn_as_in_urdf() -> None:
    urdf = """<robot name="r"><link name="a"><visual><origin xyz="1 2 3" rpy="0.3 -0.4 1.1"/>
      <geometry><box size="1 1 1"/></geometry></visual></link></robot>"""
    (shape,) = visual_shapes(urdf)
    np.testing.assert_allclose(shape.rotation, pin.rpy.rpyToMatrix(0.3, -0.4, 1.1), atol=1e-15)
    assert shape.position == (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    "urdf",
    ["<robot", '<robot><link><visual><geometry><box size="a b c"/></geometry></visual></link></robot>'],
)
def test_a_malformed_urdf_is_told(urdf: str) -> None:
    with pytest.raises(ConfigurationError, match="malformed"):
        visual_shapes(urdf)
