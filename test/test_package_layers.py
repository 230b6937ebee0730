"""Who may import whom: the maths knows no ROS, the controllers know nothing of the plant."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / "follower_humanoid"
BASE = {"core", "robot", "errors", "resources", "executables"}
ROS = {"nodes", "ros", "ros2_front", "faults"}  # faults are tried on the shell too
CHAIN = {"sensing", "gait", "balance", "control"}

# Folder → what it may import of this package besides itself and the base; folders not listed may import all.
ALLOWED: dict[str, set[str]] = {
    "core": set(),
    "robot": set(),
    "plant": set(),  # nor may the controllers import it: what the plant knows is not for them
    "leader": set(),
    **dict.fromkeys(CHAIN, CHAIN),
    "bag": {"graph"},
    "graph": {"bag", "viewer"},
}


def imports(file: Path) -> set[str]:
    """First part below the package of everything of the package that a file imports."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom):
            modules = [str(node.module)]
        parts = [module.split(".") for module in modules]
        names.update(part[1] for part in parts if part[0] == PACKAGE.name and len(part) > 1)
    return names


@pytest.mark.parametrize("folder", ALLOWED)
def test_a_folder_imports_only_what_is_below_it(folder):
    for file in (PACKAGE / folder).rglob("*.py"):
        above = imports(file) - BASE - ALLOWED[folder] - {folder}
        assert not above, f"{file.relative_to(PACKAGE)} imports {sorted(above)}"


def test_only_nodes_and_their_shell_bring_in_ros():
    # Really imported, in a process of its own: an import behind another module counts too.
    modules = sorted(
        ".".join((PACKAGE.name, *file.relative_to(PACKAGE).with_suffix("").parts))
        for file in PACKAGE.rglob("[!_]*.py")
        if file.relative_to(PACKAGE).parts[0] not in ROS
    )
    code = (
        "import importlib, sys\n"
        "for name in sys.argv[1:]:\n"
        "    importlib.import_module(name)\n"
        "    ros = [m for m in sys.modules if m == 'rclpy' or m.endswith('_msgs') or m == 'std_srvs']\n"
        "    assert not ros, f'{name} brings in {ros}'\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *modules], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
