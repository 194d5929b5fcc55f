"""Steps a second of the closed loop, single and batched, beside highway-env; prints JSON.

    python benchmarks/closed_loop.py

Of `avsec/ClosedLoop-v0`, by random drivers and by the planner; of `avsec/ClosedLoopAttack-v0`, by
random attackers while the planner drives; and of whole drives as `avsec drive` makes them, films
and metrics included, with highway-env and without.

On one core, by CPU time, resets included; steps that only reset are not counted.  Random drivers
keep a random habit; planners replan every 0.5 s.  All turns are taken in rounds, one after the
other, so that none has a better hour than another; the median round counts, after one that
compiles.  highway-env's own `highway-v0` and `highway-fast-v0` are played with random actions at
their default of one action a second: `simulated` counts steps of the simulation for all.
"""

from __future__ import annotations

import json
import statistics
import time
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import highway_env
import numpy as np

import avsec_gym
from avsec_gym.closed_loop.error_model.model import ErrorModel, Ghosts, Spread
from avsec_gym.drives.one_drive import DriveTask, drive
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.envs.planner_driver import PlannerDriver, PlannerDrivers

ID, ATTACK = "avsec/ClosedLoop-v0", "avsec/ClosedLoopAttack-v0"
ROUNDS, SECONDS = 5, 1.0
"""Rounds after the first one, and CPU time of each turn in a round."""
COUNT = 64
"""Environments in a batch."""
SCENES = 20
MODEL = ErrorModel(
    found=(4.0, -1.0, -0.3, -3.0, -3.0, -1.0),
    spreads={
        "radial": Spread(0.1, 0.3, 0.6, 4.0),
        "lateral": Spread(0.0, 0.1, 0.4, 5.0),
        "turn": Spread(0.0, 0.05, 0.2, 3.0),
        "log_length": Spread(0.0, 0.06, 0.0, 6.0),
        "log_width": Spread(0.0, 0.04, 0.0, 6.0),
    },
    ghosts=Ghosts(0.3, ((20.0, -2.0, 0.1, 1.5, 1.6, 4.0), (12.0, 3.0, 3.0, 1.4, 1.7, 4.2)), 0.3),
)
"""About as good as the shipped detectors; how fast it is does not depend on that."""
Turn = Callable[[], int]
"""Takes some steps, and returns how many it took."""


def single(made: gym.Env[Any, Any], action: Callable[[Any], Any]) -> Turn:
    """Steps of one environment."""
    shown, _ = made.reset(seed=0)

    def turn() -> int:
        nonlocal shown
        shown, _, terminated, truncated, _ = made.step(action(shown))
        if terminated or truncated:
            shown, _ = made.reset()
        return 1

    return turn


def batched(made: Any, action: Callable[[Any], Any]) -> Turn:
    """Steps of a batch of environments."""
    shown, _ = made.reset(seed=0)

    def turn() -> int:
        nonlocal shown
        shown, *_, info = made.step(action(shown))
        return int(np.count_nonzero(info["outcome"] != "reset"))

    return turn


def habits(size: tuple[int, ...]) -> Callable[[Any], Any]:
    """Random drivers: a habit that lasts for a while, and noise."""
    generator = np.random.default_rng(0)
    habit, steps = np.zeros(size), 0

    def action(_: Any) -> Any:
        nonlocal habit, steps
        if steps % 25 == 0:
            habit = generator.uniform(-1, 1, size) * (0.6, 0.04)
        steps += 1
        return np.asarray(habit + generator.normal(size=size) * (0.3, 0.05), np.float32)

    return action


def whole_drives(made: Any) -> Turn:
    """Steps of whole drives, one after the other."""
    ids, number = made.unwrapped.scenes.ids, 0

    def turn() -> int:
        nonlocal number
        task = DriveTask("car", ids[number % len(ids)], "straight", number)
        number += 1
        return int(drive(made, task).row["steps"])

    return turn


def turns() -> dict[str, tuple[Turn, int]]:
    """What is measured: turns, and the steps of the simulation that each action takes."""
    found: dict[str, tuple[Turn, int]] = {}
    for name in ("highway-v0", "highway-fast-v0"):
        env = gym.make(name)
        frequency = env.unwrapped.config["simulation_frequency"]  # type: ignore[attr-defined]
        found[f"{name}, random"] = (
            single(env, lambda _, e=env: e.action_space.sample()),
            frequency,
        )
    for source in ("layouts", "drives"):
        for level, perception in {
            "truth": "truth",
            "error model": {"name": "error_model", "model": MODEL},
        }.items():
            given = {"scenarios": {"source": source, "count": SCENES}, "perception": perception}
            name = f"{source}, {level}"
            env = gym.make(ID, disable_env_checker=True, **given)
            found[f"{name}, single, random"] = single(env, habits((2,))), 2
            env = gym.make(ID, disable_env_checker=True, **given)
            drives = PlannerDriver(env)
            found[f"{name}, single, planner"] = single(env, lambda o, d=drives: d.predict(o)[0]), 2
            many = gym.make_vec(ID, num_envs=COUNT, **given)
            found[f"{name}, batched, random"] = batched(many, habits((COUNT, 2))), 2
            many = gym.make_vec(ID, num_envs=COUNT, **given)
            drivers = PlannerDrivers(many)
            found[f"{name}, batched, planner"] = (
                batched(many, lambda o, d=drivers: d.predict(o)[0]),
                2,
            )
            env = gym.make(ATTACK, disable_env_checker=True, **given)
            found[f"{name}, single, attack"] = (
                single(env, lambda _, e=env: e.action_space.sample()),
                2,
            )
            many = gym.make_vec(ATTACK, num_envs=COUNT, **given)
            found[f"{name}, batched, attack"] = (
                batched(many, lambda _, m=many: m.action_space.sample()),
                2,
            )
            on_highway_env = gym.make(ID, disable_env_checker=True, **given)
            found[f"{name}, whole drives, on highway-env"] = whole_drives(on_highway_env), 2
            light: Any = DriveSetting("car", {"perception": perception}).environment(
                given["scenarios"]
            )
            found[f"{name}, whole drives, without it"] = whole_drives(light), 2
    return found


def rate(turn: Turn) -> float:
    """Steps a second of CPU time."""
    steps, begun = 0, time.process_time()
    while time.process_time() - begun < SECONDS:
        steps += turn()
    return steps / (time.process_time() - begun)


def main() -> None:
    """Measure in rounds, print JSON."""
    gym.register_envs(avsec_gym)
    gym.register_envs(highway_env)
    measured = turns()
    rates = [{name: rate(turn) for name, (turn, _) in measured.items()} for _ in range(ROUNDS + 1)]
    result = {}
    for name, (_, simulated) in measured.items():
        steps = statistics.median(each[name] for each in rates[1:])
        result[name] = {
            "steps_per_second": round(steps),
            "simulated_per_second": round(simulated * steps),
        }
    print(json.dumps({"environments_in_a_batch": COUNT, "rates": result}, indent=1))


if __name__ == "__main__":
    main()
