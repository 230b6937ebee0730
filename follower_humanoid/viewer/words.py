"""The robot's state in words."""

from __future__ import annotations

import math

from follower_humanoid.viewer.moment import Moment

_SILENT = 1.5  # wall time without a new state after which the simulation counts as stopped [s]
_LEANING = 0.1  # N
WAITING, GOOD, BAD = "waiting", "good", "bad"


def state_words(moment: Moment) -> tuple[str, str]:
    """How it is (`waiting`, `good` or `bad`) and one sentence about the robot."""
    simulator = moment.reports.get("simulator", {})
    fallen = simulator.get("fallen") == "True"
    ended = simulator.get("ended", "")
    if ended:
        return (BAD if fallen else WAITING), f"The run is over: {ended}."
    if not moment.has_robot:
        return WAITING, "Waiting for a robot."
    if fallen:
        return BAD, f"Fallen: {simulator.get('error', 'it lies on the ground')}."
    if moment.missing:
        return BAD, f"Missing: {', '.join(moment.missing)}."
    if moment.silent > _SILENT:
        return WAITING, "The simulation stands still."
    return GOOD, _motion(moment)


def _motion(moment: Moment) -> str:
    led = [
        side
        for side in ("left", "right")
        if any(abs(part) > _LEANING for part in moment.force(f"{side}_hand/applied"))
    ]
    by = f", led by the {' and the '.join(led)} hand" if led else ""
    if "gait" in moment and moment["gait"].walk_speed > 0.0:
        return f"Walking{by}."
    if "primitives" in moment and moment["primitives"].names:
        return f"Coming to a stand{by}."
    return f"Standing{by}."


def figures(moment: Moment) -> list[tuple[str, str]]:
    """Name and value of what is worth a number."""
    margin = 1000.0 * moment.zmp_margin()
    rows = [("time", f"{moment.time:.2f} s")]
    if math.isfinite(moment.speed):
        rows.append(("real-time factor", f"{moment.speed:.2f}"))
    if "gait" in moment:
        gait = moment["gait"]
        rows.append(("walking speed", f"{gait.walk_speed:.2f} of nominal"))
        rows.append(("step length", f"{gait.step_length:.2f} of nominal"))
    steps = moment.reports.get("motion_composition", {}).get("half_steps", "")
    if steps:
        rows.append(("half-steps", f"{float(steps):.0f}"))
    rows.append(("ZMP margin", _number(margin, "{:.0f} mm")))
    rows.append(("largest voltage", _number(moment.peak_voltage(), "{:.1f} V")))
    return rows


def _number(value: float, form: str) -> str:
    return form.format(value) if math.isfinite(value) else "–"
