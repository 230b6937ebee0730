"""Two graphs at once, which must not disturb each other."""

from __future__ import annotations

from collections.abc import Iterator

from follower_humanoid.bench.check import Check
from follower_humanoid.faults.case import Effort, survived
from follower_humanoid.faults.graph_run import GraphRun, graph_run, own_domain


def side_by_side(effort: Effort) -> Iterator[Check]:
    """Two namespaces of one domain, and in the long form two domains: each walks as if it were alone."""
    options = ("--leader", "fig4", "--duration", "1", "--composed")
    domain = own_domain()
    yield _both("namespaces", (*options, "--namespace"), domain, domain)
    if not effort.brief:
        yield _both("domains", options, domain, domain % 100 + 1)


def _both(how: str, options: tuple[str, ...], first: int, second: int) -> Check:
    names = (("one",), ("two",)) if options[-1] == "--namespace" else ((), ())
    with graph_run(*(option for option in options if option != "--namespace"), domain=first) as run:
        alone, _ = _walk_of(run)
    with (
        graph_run(*options, *names[0], domain=first) as one,
        graph_run(*options, *names[1], domain=second) as two,
    ):
        status = (one.status(), two.status())
        (walk_one, notes_one), (walk_two, notes_two) = _walk_of(one), _walk_of(two)
    same = walk_one == walk_two == alone != ""
    whole = not notes_one and not notes_two
    observed = f"status {status[0]} and {status[1]}, {'the same walk' if same else 'another walk'}"
    observed += "".join(f"; {note}" for note in (*notes_one, *notes_two))
    good = status == (0, 0) and same and whole
    return survived(f"two graphs in two {how}", "both walk as if alone", observed, good)


def _walk_of(run: GraphRun) -> tuple[str, tuple[str, ...]]:
    """Hash of a run's walk, and what its bag lacks."""
    run.status()
    bag = run.recorded()
    return ("", ("no bag",)) if bag is None else (bag.joint_hash(), bag.notes)
