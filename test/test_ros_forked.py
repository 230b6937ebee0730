"""A forked process lives as a started one does: its name, its status, its signals."""

import subprocess
import sys
from pathlib import Path

from graph_bench import PATIENCE

CASES = Path(__file__).with_name("forked_cases.py")


def test_forked_processes_where_no_middleware_runs_yet():
    """As in bringup: threads of a middleware that an earlier test started would be missing after a fork."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(CASES)]
    result = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
