"""The scripts make an environment once, keep it up to date, and say plainly why they cannot."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

# Stands in for Python: answers the probes, makes a "venv" that is itself again, notes what else it is asked.
PYTHON = """#!/bin/sh
case "$1" in
--version) echo "Python 3.11.0" ;;
-c) case "$2" in *"import pybullet"*|*"sys.version_info < (3, 12)"*|*rclpy*) exit 1 ;; esac ;;
-m) case "$2" in
    venv) for folder; do :; done
          mkdir -p "$folder/bin" && touch "$folder/pyvenv.cfg" && cp "$0" "$folder/bin/python3" ;;
    *) shift; echo "$@" >>"$CALLS" ;;
    esac ;;
*) echo "$@" >>"$CALLS" ;;
esac
"""


class Checkout:
    """A copy of the scripts with a stand-in for Python."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "check out"  # a blank in a path must not matter
        self.calls = folder / "calls"
        self.calls.touch()
        self.interpreter = folder / "python"
        self.interpreter.write_text(PYTHON, encoding="utf-8")
        self.interpreter.chmod(0o755)
        (self.root / "follower_humanoid").mkdir(parents=True)
        (self.root / ".ci").mkdir()
        shutil.copytree(ROOT / "scripts", self.root / "scripts", symlinks=True)
        shutil.copy(ROOT / ".ci" / "run", self.root / ".ci" / "run")
        shutil.copy(ROOT / "setup.py", self.root)
        shutil.copy(ROOT / "follower_humanoid" / "executables.py", self.root / "follower_humanoid")

    def run(self, script: str, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
        base = {key: os.environ[key] for key in ("PATH", "HOME") if key in os.environ}
        base |= {"CALLS": str(self.calls), "FOLLOWER_PYTHON": str(self.interpreter)}
        base |= {"FOLLOWER_NO_APT": "1"}
        return subprocess.run(
            [str(self.root / script), *arguments],
            env={**base, **environment},
            cwd=self.root.parent,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )

    def called(self) -> list[str]:
        """What Python was asked for since the last time."""
        lines = self.calls.read_text(encoding="utf-8").splitlines()
        self.calls.write_text("", encoding="utf-8")
        return lines


@pytest.fixture
def checkout(tmp_path: Path) -> Checkout:
    return Checkout(tmp_path)


def test_first_start_installs_and_runs_with_the_arguments(checkout):
    done = checkout.run("scripts/bringup", "--leader", "fig 4")
    assert done.returncode == 0, done.stderr
    install, compilation, run = checkout.called()
    assert install.startswith("pip install")
    assert install.endswith(f"--editable {checkout.root}")
    assert compilation == "follower_humanoid.compile"
    assert run == f"{checkout.root}/scripts/exe/bringup --leader fig 4"
    assert done.stdout == ""
    assert "installing" in done.stderr


def test_second_start_installs_nothing_and_says_nothing(checkout):
    checkout.run("scripts/bringup")
    checkout.called()
    done = checkout.run("scripts/bringup")
    assert checkout.called() == [f"{checkout.root}/scripts/exe/bringup"]
    assert done.stderr == ""


def test_a_changed_setup_is_installed_again(checkout):
    checkout.run("scripts/bringup")
    checkout.called()
    with (checkout.root / "setup.py").open("a", encoding="utf-8") as file:
        file.write("# changed\n")
    checkout.run("scripts/bringup")
    assert len(checkout.called()) == 3


def test_tests_need_their_own_tools_and_run_style_types_and_pytest(checkout):
    checkout.run("scripts/bringup")
    checkout.called()
    done = checkout.run("scripts/test", "-k", "zmp")
    assert done.returncode == 0, done.stderr
    install, _, ruff, mypy, pytest_call = checkout.called()
    assert install.endswith(f"--editable {checkout.root}[test]")
    assert (ruff, mypy, pytest_call) == ("ruff check .", "mypy", "pytest -k zmp")


def test_an_environment_for_tests_is_enough_to_run(checkout):
    checkout.run("scripts/test")
    checkout.called()
    checkout.run("scripts/bringup")
    assert len(checkout.called()) == 1


def test_an_environment_whose_interpreter_is_gone_is_made_anew(checkout):
    checkout.run("scripts/bringup")
    checkout.called()
    (checkout.root / ".venv" / "bin" / "python3").unlink()
    assert checkout.run("scripts/bringup").returncode == 0
    assert len(checkout.called()) == 3


def test_ci_runs_the_tests(checkout):
    assert checkout.run(".ci/run").returncode == 0
    assert checkout.called()[-1] == "pytest"


@pytest.mark.parametrize(
    ("status", "again"),
    [
        (1, True),  # tests failed
        (139, True),  # it crashed, and could not note which
        (2, False),  # stopped, or a file of tests cannot be read: few or none were run
    ],
)
def test_ci_runs_failed_tests_once_more_with_the_same_arguments(checkout, status, again):
    fails = f'[ "$(grep -c ^pytest "$CALLS")" -gt 1 ] || exit {status}'
    once = f'pytest) shift; echo "$@" >>"$CALLS"; {fails} ;;\n    *) shift;'
    checkout.interpreter.write_text(PYTHON.replace("*) shift;", once), encoding="utf-8")
    done = checkout.run(".ci/run", "-k", "zmp")
    tested = [line for line in checkout.called() if line.startswith("pytest")]
    once_more = "pytest --last-failed --last-failed-no-failures all -k zmp"
    assert tested == ["pytest -k zmp", *([once_more] if again else [])]
    assert done.returncode == (0 if again else status)


def test_ci_takes_no_failures_of_other_days_for_its_own(checkout):
    noted = checkout.root / ".pytest_cache" / "v" / "cache" / "lastfailed"
    noted.parent.mkdir(parents=True)
    noted.touch()
    # It does not get as far as the tests: there is no network for once.
    checkout.interpreter.write_text(PYTHON.replace("*) shift;", "pip) exit 1 ;; *) shift;"), encoding="utf-8")
    assert checkout.run(".ci/run").returncode == 1
    assert not noted.exists()


def test_benchmark_passes_its_arguments_on(checkout):
    checkout.run("scripts/benchmark", "fig4")
    assert checkout.called()[-1] == "follower_humanoid.bench fig4"


def test_a_failed_installation_is_tried_again(checkout):
    checkout.interpreter.write_text(PYTHON.replace("*) shift;", "pip) exit 1 ;; *) shift;"), encoding="utf-8")
    done = checkout.run("scripts/bringup")
    assert done.returncode == 1
    assert "pip could not install" in done.stderr
    shutil.rmtree(checkout.root / ".venv")
    checkout.interpreter.write_text(PYTHON, encoding="utf-8")
    assert checkout.run("scripts/bringup").returncode == 0


def test_the_environment_may_be_elsewhere(checkout, tmp_path):
    assert checkout.run("scripts/bringup", FOLLOWER_VENV="some/where").returncode == 0
    assert (tmp_path / "some" / "where" / "pyvenv.cfg").is_file()
    assert not (checkout.root / ".venv").exists()


def test_a_folder_that_is_no_environment_is_left_alone(checkout, tmp_path):
    (tmp_path / "precious").mkdir()
    (tmp_path / "precious" / "data").touch()
    done = checkout.run("scripts/bringup", FOLLOWER_VENV=str(tmp_path / "precious"))
    assert done.returncode == 1
    assert "in the way" in done.stderr
    assert (tmp_path / "precious" / "data").exists()


@pytest.mark.parametrize(
    ("environment", "told"),
    [
        ({"FOLLOWER_PYTHON": "/bin/false"}, "no Python 3.10, 3.11 or 3.12 with venv among: /bin/false"),
        ({"FOLLOWER_PYTHON": "/no/such/python"}, "no Python 3.10, 3.11 or 3.12"),
        ({"ROS_DISTRO": "humble"}, "ROS 2 'humble' is sourced"),
    ],
)
def test_what_is_missing_is_told_in_one_line(checkout, environment, told):
    done = checkout.run("scripts/bringup", **environment)
    assert done.returncode == 1
    assert done.stderr.startswith("error: ")
    assert told in done.stderr
    assert done.stderr.count("\n") == 1
    assert checkout.called() == []


@pytest.mark.parametrize(("argument", "status"), [("--help", 0), ("-h", 0), ("--brief", 2)])
def test_pictures_are_not_made_by_way_of_asking(tmp_path, argument, status):
    checkout = Checkout(tmp_path)
    asked = checkout.run("scripts/pictures", argument)
    assert asked.returncode == status
    assert "usage: scripts/pictures" in (asked.stderr if status else asked.stdout)
    assert checkout.called() == []
    assert not (checkout.root / ".venv").exists()
