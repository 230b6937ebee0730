"""package.xml, setup.py, the table of executables and the imports say the same."""

import ast
import importlib.util
import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import pytest

from follower_humanoid.executables import EXECUTABLES, console_script

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "follower_humanoid"

# Import name → name in package.xml; None: brought by another dependency or told in a comment there.
ROSDEP = {
    "matplotlib": "python3-matplotlib",
    "numba": "python3-numba",
    "numpy": "python3-numpy",
    "scipy": "python3-scipy",
    "setproctitle": "python3-setproctitle",
    "yaml": "python3-yaml",
    "llvmlite": None,
    "lz4": None,
    "mcap": None,
    "pinocchio": None,
    "viser": None,
    "zstandard": None,
}
# Import name → requirement in setup.py, where they differ.
PYPI = {"pinocchio": "pin", "yaml": "pyyaml", "llvmlite": "numba"}


def imported_modules() -> set[str]:
    """Top-level names of everything that the package imports and does not define."""
    names: set[str] = set()
    for file in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names.update(alias.name.split(".")[0] for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                names.add(str(node.module).split(".")[0])
    return names - set(sys.stdlib_module_names) - {"follower_humanoid"}


def is_ros(name: str) -> bool:
    return name not in ROSDEP


@pytest.fixture(scope="module")
def package_xml() -> ElementTree.Element:
    return ElementTree.parse(ROOT / "package.xml").getroot()


def setup_words(ament_prefix_path: str) -> dict[str, Any]:
    """What setup.py tells setuptools in a shell with these ROS prefixes."""
    code = (
        "import sys, runpy, setuptools\n"
        "setuptools.setup = lambda **words: sys.stdout.write(repr(words))\n"
        "runpy.run_path('setup.py', run_name='__main__')"
    )
    environment = {**os.environ, "AMENT_PREFIX_PATH": ament_prefix_path}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, env=environment, capture_output=True, text=True, check=True
    )
    words: dict[str, Any] = ast.literal_eval(done.stdout)
    return words


@pytest.fixture(scope="module")
def setup() -> dict[str, Any]:
    return setup_words("")


def test_format_is_3_and_build_type_is_ament_python(package_xml):
    assert package_xml.get("format") == "3"
    assert package_xml.findtext("export/build_type") == "ament_python"


def test_version_license_and_name_agree(package_xml, setup):
    for tag in ("name", "version", "license"):
        assert package_xml.findtext(tag) == setup[tag]


def test_package_xml_names_every_ros_and_debian_package_that_is_imported(package_xml):
    declared = {element.text for element in package_xml.findall("exec_depend")}
    needed = {name if is_ros(name) else ROSDEP[name] for name in imported_modules()} - {None}
    assert needed <= declared


def test_setup_requires_every_python_package_that_is_imported(setup):
    required = {line.split(">")[0].split("[")[0] for line in setup["install_requires"]}
    needed = {PYPI.get(name, name) for name in imported_modules() if not is_ros(name)}
    assert needed <= required
    assert {"ros-jazzy-rclpy", "ros-jazzy-common-interfaces", "pybullet"} <= required


def test_sourced_ros_is_not_hidden_by_wheels(tmp_path):
    (tmp_path / "share" / "rclpy").mkdir(parents=True)
    words = setup_words(f"/nowhere:{tmp_path}")
    required = " ".join(words["install_requires"])
    assert "pybullet" in required
    assert "rclpy" not in required
    assert not any(script.startswith("ros2 ") for script in words["entry_points"]["console_scripts"])


def test_wheels_of_an_environment_are_no_ros_installation(tmp_path, setup):
    """Installed once more in the shell in which `ros2 run` finds the package."""
    (tmp_path / "share" / "rclpy").mkdir(parents=True)
    (tmp_path / "pyvenv.cfg").write_text("version = 3.11\n")
    words = setup_words(str(tmp_path))
    assert words["install_requires"] == setup["install_requires"]
    assert words["entry_points"] == setup["entry_points"]


def test_ros2_has_a_stand_in_where_no_ros_is_sourced(setup):
    assert "ros2 = follower_humanoid.ros2_front.main:main" in setup["entry_points"]["console_scripts"]
    assert importlib.util.find_spec("follower_humanoid.ros2_front.main")


@pytest.mark.parametrize("name", EXECUTABLES)
def test_executable_has_its_module_its_file_and_its_console_script(name, setup):
    module = f"follower_humanoid.nodes.{name}"
    assert importlib.util.find_spec(module), f"{module} is missing"
    assert os.access(ROOT / "scripts" / "exe" / name, os.X_OK)
    assert f"{console_script(name)} = {module}:main" in setup["entry_points"]["console_scripts"]


def test_no_file_in_scripts_exe_is_missing_from_the_table():
    files = {path.name for path in (ROOT / "scripts" / "exe").iterdir() if not path.name.startswith("_")}
    assert files == set(EXECUTABLES)


def test_every_module_with_a_main_in_nodes_is_an_executable():
    mains = {
        file.stem
        for file in (PACKAGE / "nodes").glob("*.py")
        if any(
            isinstance(node, ast.FunctionDef) and node.name == "main"
            for node in ast.parse(file.read_text(encoding="utf-8")).body
        )
    }
    assert mains <= set(EXECUTABLES)


def test_licence_text_is_that_of_apache():
    text = (ROOT / "LICENSE").read_text(encoding="utf-8")
    assert "Apache License" in text
    assert "Version 2.0, January 2004" in text
