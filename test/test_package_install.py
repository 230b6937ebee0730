"""What pip and the four ways of colcon install: every file where ROS 2 looks for it, and it runs."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from follower_humanoid.executables import EXECUTABLES, console_script

ROOT = Path(__file__).resolve().parent.parent
NAME = "follower_humanoid"

# Run where no checkout is near: what is installed must find its own files.
PROBE = """
import follower_humanoid
from follower_humanoid.resources import executable_path, share_path
print(follower_humanoid.__file__)
print(share_path("urdf/follower.urdf"))
print(share_path("config/follower.yaml"))
print(executable_path("simulator"))
"""


def run(command: list[str], folder: Path, **environment: str) -> str:
    done = subprocess.run(
        command, cwd=folder, env={**os.environ, **environment}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def check_prefix(prefix: Path) -> None:
    """Every file of the package under one installation prefix."""
    share = prefix / "share"
    assert (share / "ament_index/resource_index/packages" / NAME).is_file()
    for relative in ("package.xml", "urdf/follower.urdf", "config/follower.yaml"):
        assert (share / NAME / relative).is_file(), relative
    assert sorted(path.name for path in (prefix / "lib" / NAME).iterdir()) == sorted(EXECUTABLES)
    for name in EXECUTABLES:
        assert os.access(prefix / "lib" / NAME / name, os.X_OK), name
        assert os.access(prefix / "bin" / console_script(name), os.X_OK), name


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files under version control that make up the package, in a folder that may be built in."""
    folder = tmp_path_factory.mktemp("workspace") / "src" / NAME
    folder.mkdir(parents=True)
    for name in (NAME, "config", "launch", "resource", "scripts", "urdf"):
        if (ROOT / name).is_dir():
            shutil.copytree(
                ROOT / name, folder / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__")
            )
    for name in ("package.xml", "setup.py", "pyproject.toml", "LICENSE"):
        shutil.copy(ROOT / name, folder)
    return folder


@pytest.fixture(scope="module")
def pip_prefix(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    prefix = tmp_path_factory.mktemp("pip")
    offline = ["--no-deps", "--no-index", "--no-build-isolation", "--ignore-installed"]
    run([sys.executable, "-m", "pip", "install", *offline, "--prefix", str(prefix), str(source)], prefix)
    return prefix


def site_packages(prefix: Path) -> str:
    return str(next(prefix.glob("lib/python3*/site-packages")))


def test_pip_installs_every_file(pip_prefix):
    check_prefix(pip_prefix)
    assert (Path(site_packages(pip_prefix)) / NAME / "py.typed").is_file()


def test_what_pip_installed_finds_its_own_files(pip_prefix):
    found = run([sys.executable, "-c", PROBE], Path("/"), PYTHONPATH=site_packages(pip_prefix)).split()
    assert all(path.startswith(str(pip_prefix)) for path in found), found


def test_what_pip_installed_runs(pip_prefix):
    command = [str(pip_prefix / "lib" / NAME / "bringup"), "--no-such-option"]
    environment = {**os.environ, "PYTHONPATH": site_packages(pip_prefix)}
    done = subprocess.run(command, cwd="/", env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "--no-such-option" in done.stderr
    assert done.stderr.strip().count("\n") == 0


@pytest.mark.parametrize(
    "options",
    [[], ["--symlink-install"], ["--merge-install"], ["--merge-install", "--symlink-install"]],
    ids=lambda options: " ".join(options) or "plain",
)
def test_colcon_builds(source, options):
    workspace = source.parent.parent
    colcon = shutil.which("colcon", path=f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    assert colcon, "colcon is not installed"
    for folder in ("build", "install", "log"):
        shutil.rmtree(workspace / folder, ignore_errors=True)
    run([sys.executable, colcon, "build", *options], workspace)
    prefix = workspace / "install" if "--merge-install" in options else workspace / "install" / NAME
    check_prefix(prefix)
    probe = f'. {workspace}/install/setup.sh && exec "{sys.executable}" -c "$PROBE"'
    found = run(["sh", "-c", probe], Path("/"), PROBE=PROBE, PYTHONPATH="").split()
    assert all(path.startswith(str(workspace)) for path in found), found
