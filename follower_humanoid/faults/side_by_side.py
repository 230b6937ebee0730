"""Two graphs at once, which must not disturb each other."""

from __future__ import annotations

from collections.abc import Iterator

from follower_humanoid.bench.check import Check
from follower_humanoid.faults.case import Effort, survived
from follower_humanoid.faults.graph_run import graph_run, own_domain


def side_by_side(effort: Effort) -> Iterator[Check]:
    """Two namespaces of one domain, and in the long form two domains: each walks as if it were alone."""
    options = ("--leader", "fig4", "--duration", "1", "--composed")
    domain = own_domain()
    yield _both("namespaces", (*options, "--namespace"), domain, domain)
    if not effort.brief:
        yield _both("domains", options, domain, domain % 100 + 1)


def _both(how: str, options: tuple[str, ...], first: int, second: int) -> Check:
    names = (("one",), ("two",)) if options[-1] == "--namespace" else ((), ())
    with graph_run(*[o for o in options if o != "--namespace"], domain=first) as alone:
        alone.status()
        bag = alone.recorded()
        walk_alone = "" if bag is None else bag.joint_hash()
    with (
        graph_run(*options, *names[0], domain=first) as one,
        graph_run(*options, *names[1], domain=second) as two,
    ):
        status = (one.status(), two.status())
        bags = [run.recorded() for run in (one, two)]
    hashes = [bag.joint_hash() for bag in bags if bag is not None and not bag.notes]
    same = hashes == [walk_alone, walk_alone]
    observed = f"status {status[0]} and {status[1]}, {'the same walk' if same else 'another walk'}"
    return survived(f"two graphs in two {how}", "both walk as if alone", observed, status == (0, 0) and same)
