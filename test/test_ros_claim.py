"""Names of nodes: held by one, free again when that one is gone."""

import os
import subprocess
import sys

import pytest
from graph_bench import ENDLESS, beside

from follower_humanoid.errors import ConfigurationError
from follower_humanoid.ros.claim import Claim

SPACE = f"test_{os.getpid()}"


@pytest.mark.parametrize("other", [["b", "c"], ["a"], ["c", "a"]])
def test_a_name_is_held_once_and_a_refused_claim_holds_nothing(other):
    held = Claim(7, SPACE, ["a", "b"])
    with pytest.raises(ConfigurationError, match=rf"domain 7 under namespace '/{SPACE}': .*--namespace"):
        Claim(7, SPACE, other)
    Claim(7, SPACE, ["c"]).close()
    held.close()
    Claim(7, SPACE, other).close()


@pytest.mark.parametrize(
    ("domain", "space", "nodes"), [(8, SPACE, "ab"), (7, f"{SPACE}x", "ab"), (7, SPACE, "cd")]
)
def test_other_domains_namespaces_and_nodes_are_free(domain, space, nodes):
    held = Claim(7, SPACE, ["a", "b"])
    Claim(domain, space, list(nodes)).close()
    held.close()


def test_a_namespace_may_be_long():
    held = Claim(7, SPACE + "x" * 200, ["a"])
    Claim(7, SPACE + "x" * 199, ["a"]).close()
    held.close()


def test_it_is_held_as_long_as_its_context_lasts():
    with Claim(7, SPACE, ["a"]), pytest.raises(ConfigurationError):
        Claim(7, SPACE, ["a"])
    Claim(7, SPACE, ["a"]).close()


def test_what_the_system_forbids_is_not_held_against_anybody(monkeypatch):
    def forbidden(self, address):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("socket.socket.bind", forbidden)
    with Claim(7, SPACE, ["a"]), Claim(7, SPACE, ["a"]):
        pass


def test_it_ends_with_its_process_even_if_that_is_killed():
    code = (
        "import time; from follower_humanoid.ros.claim import Claim; "
        f"held = Claim(7, {SPACE!r}, ['a']); print(flush=True); time.sleep({ENDLESS})"
    )
    with beside(subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)) as process:
        process.stdout.readline()
        with pytest.raises(ConfigurationError):
            Claim(7, SPACE, ["a"])
    Claim(7, SPACE, ["a"]).close()
