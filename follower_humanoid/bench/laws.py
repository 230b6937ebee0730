"""The paper's own balance law, and what each part of the chain is good for: rows of `--robust`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from follower_humanoid.bench.check import NO_FALL, Check, at_least, at_most
from follower_humanoid.bench.disturbances import FIG4_PULL, one_run
from follower_humanoid.bench.disturbed import Course, Push
from follower_humanoid.bench.measures import zmp_error, zmp_margins
from follower_humanoid.bench.scenarios import FIG_DURATION, Evidence
from follower_humanoid.graph.simulate import Parameters, simulate

ABLATIONS: dict[str, Parameters] = {
    "balance feedback off": {"zmp_balance": {"feedback": False}},
    "DCM preview off": {"motion_composition": {"dcm_preview": False}},
    "disturbance estimator off": {"leg_controller": {"sliding_mode.estimate": False}},
    "hand-force compensation off": {"zmp_balance": {"hand_forces": False}},
}
HEAVIER = {"body.mass_scale": 1.1}
WORSE, LEAST = 1.1, 2e-4  # a number is worse when it grows by this factor and this much more [m]


def paper_law() -> Iterator[Check]:
    """Figs. 4 and 5 with the paper's law."""
    for figure in ("fig4", "fig5"):
        e = Evidence.of(simulate(figure, FIG_DURATION, {"zmp_balance": {"law": "paper"}}))
        lasted = float(e.motion.times[-1]) + e.run.tick
        upright = lasted > FIG_DURATION - 2 * e.run.tick
        yield Check(f"{figure}: {NO_FALL}", f"{FIG_DURATION:g} s", f"{lasted:.2f} s", upright)
        counted = [step for step in e.steps if step.counted]
        yield at_least(f"{figure}: half-steps", len(counted), 7)
        yield at_least(f"{figure}: smallest ZMP margin", _smallest_margin(e), 0.0, "mm", 1e3)
        along, across = zmp_error(e.run, e.motion, "zmp_reference", 2)
        yield at_most(f"{figure}: ZMP from plan, along", along, 0.025, "mm", 1e3)
        yield at_most(f"{figure}: ZMP from plan, across", across, 0.025, "mm", 1e3)


@dataclass(frozen=True)
class Outcome:
    """How a run went.

    Attributes:
        fall: What showed a fall, empty without one.
        errors: Of which less is better [m].
        margin: Smallest ZMP margin, of which more is better [m].
    """

    fall: str = ""
    errors: Mapping[str, float] = field(default_factory=dict)
    margin: float | None = None


def walk_heavier(parameters: Parameters) -> Outcome:
    """12 s of fig. 4 with a body 10 % heavier than the controllers know."""
    run = simulate("fig4", 12.0, {**parameters, "simulator": HEAVIER})
    if len(run["odom"].times) < 0.99 * 12.0 / run.tick:
        return Outcome(f"falls at {run['odom'].times[-1]:.1f} s")
    e = Evidence.of(run)
    along, across = zmp_error(run, e.motion, "zmp_reference", 2)
    return Outcome(errors={"ZMP error along": along, "ZMP error across": across})


def pushed_walking(parameters: Parameters) -> Outcome:
    """10 N·s sideways at 6.8 s of fig. 4."""
    course = Course(left=FIG4_PULL, push=Push(6.8, np.array([0.0, 10.0])))
    ending = one_run(course, 10.0, parameters)
    return Outcome(ending.fall or ("" if ending.settled else "not settled"), margin=ending.margin)


def hands_loaded(parameters: Parameters) -> Outcome:
    """50 N down on each hand, standing, for 6 s."""
    ending = one_run(Course(left=(0.0, 0.0, -50.0), right=(0.0, 0.0, -50.0)), 6.0, parameters)
    return Outcome(ending.fall, margin=ending.margin)


TESTS: dict[str, Callable[[Parameters], Outcome]] = {
    "heavier walk": walk_heavier,
    "push while walking": pushed_walking,
    "loaded hands": hands_loaded,
}


def ablations() -> Iterator[Check]:
    """Each part switched off alone must make something measurably worse."""
    usual = {name: test({}) for name, test in TESTS.items()}
    for what, parameters in ABLATIONS.items():
        found = [line for name, test in TESTS.items() for line in _worse(name, usual[name], test(parameters))]
        yield Check(what, "something gets worse", "; ".join(found) or "nothing", bool(found))


def _worse(name: str, usual: Outcome, without: Outcome) -> Iterator[str]:
    """What got worse, in words."""
    if without.fall and not usual.fall:
        yield f"{name}: {without.fall}"
        return
    for what, value in without.errors.items():
        before = usual.errors.get(what, math.inf)
        if value > WORSE * before + LEAST:
            yield f"{name}: {what} {1e3 * before:.1f} → {1e3 * value:.1f} mm"
    if (
        usual.margin is not None
        and without.margin is not None
        and without.margin < usual.margin / WORSE - LEAST
    ):
        yield f"{name}: ZMP margin {1e3 * usual.margin:.1f} → {1e3 * without.margin:.1f} mm"


def _smallest_margin(e: Evidence) -> float:
    margins = zmp_margins(e.run, e.motion)
    return float(np.nanmin(margins))


ROWS: dict[str, Callable[[], Iterator[Check]]] = {"law: paper": paper_law, "ablations": ablations}
