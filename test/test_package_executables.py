"""An executable finds the interpreter of its own installation, and its process carries its name."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from follower_humanoid.errors import ConfigurationError
from follower_humanoid.executables import EXECUTABLES
from follower_humanoid.resources import executable_path, node_command, share_path

FILES = Path(__file__).resolve().parent.parent / "scripts" / "exe"


def stub(path: Path, text: str) -> Path:
    """An executable file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    path.chmod(0o755)
    return path


def talking_interpreter(path: Path) -> Path:
    """Says its own name and what it was given, in place of Python."""
    return stub(path, f'#!/bin/sh\necho {path.name} "$@"\n')


@pytest.fixture
def prefix(tmp_path: Path) -> Path:
    """An installation with one executable and no interpreter."""
    folder = tmp_path / "lib" / "follower_humanoid"
    folder.mkdir(parents=True)
    shutil.copy(FILES / "leader", folder / "leader")
    return tmp_path


def run(prefix: Path, path: str = "") -> str:
    environment = {**os.environ, "PATH": f"{path}:/usr/bin:/bin"}
    command = [str(prefix / "lib" / "follower_humanoid" / "leader"), "--option", "two words"]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout


def test_interpreter_of_the_console_script_comes_first(prefix):
    talking_interpreter(prefix / "bin" / "python3")
    own = talking_interpreter(prefix / "elsewhere" / "python3.10")
    stub(prefix / "bin" / "follower_humanoid_leader", f"#!{own}\n")
    assert run(prefix).startswith("python3.10 ")


def test_interpreter_of_the_venv_comes_next(prefix):
    talking_interpreter(prefix / "bin" / "python3")
    stub(prefix / "bin" / "follower_humanoid_leader", "#!/bin/sh\n'''exec' a-very-long-path\n")
    assert run(prefix, path=str(prefix)).startswith("python3 ")


def test_interpreter_of_the_path_comes_last(prefix):
    talking_interpreter(prefix / "path" / "python3")
    assert run(prefix, path=str(prefix / "path")).startswith("python3 ")


def test_the_command_line_names_the_node_and_keeps_the_arguments(prefix):
    talking_interpreter(prefix / "bin" / "python3")
    assert run(prefix) == f"python3 {prefix}/lib/follower_humanoid/leader --option two words\n"


def test_python_runs_the_module_that_the_file_is_named_after(prefix):
    # The true interpreter, a package of the same name with one node: it must get the arguments,
    # give its exit status, and be called by its name.
    package = prefix / "site" / "follower_humanoid"
    (package / "nodes").mkdir(parents=True)
    shutil.copy(FILES.parent.parent / "follower_humanoid" / "executables.py", package)
    for folder in (package, package / "nodes"):
        (folder / "__init__.py").touch()
    (package / "nodes" / "leader.py").write_text(
        "import sys\n"
        "def main(args=None):\n"
        "    print(sys.argv[1:], open('/proc/self/cmdline').read().split(chr(0))[:2])\n"
        "    return 3\n",
        encoding="utf-8",
    )
    file = prefix / "lib" / "follower_humanoid" / "leader"
    (prefix / "bin").mkdir()
    (prefix / "bin" / "python3").symlink_to(sys.executable)
    done = subprocess.run(
        [sys.executable, str(file), "a", "b c"],
        env={**os.environ, "PYTHONPATH": str(prefix / "site")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 3, done.stderr
    assert done.stdout == f"['a', 'b c'] {[sys.executable, str(file)]}\n"


@pytest.mark.parametrize("name", EXECUTABLES)
def test_the_checkout_has_every_executable(name):
    assert executable_path(name) == FILES / name
    assert node_command(name) == [sys.executable, str(FILES / name)]


def test_the_checkout_has_the_shared_files():
    for relative in ("package.xml", "urdf/follower.urdf", "config/follower.yaml"):
        assert share_path(relative) == FILES.parent.parent / relative


def test_what_does_not_exist_is_told_with_what_does():
    with pytest.raises(ConfigurationError, match=r"no executable 'walker'; valid: .*simulator"):
        executable_path("walker")
    with pytest.raises(ConfigurationError, match=r"config/none\.yaml .* not found; looked in: /"):
        share_path("config/none.yaml")
