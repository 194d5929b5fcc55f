"""Experiments whose cells compute from a seed, wait, fail or end their process.

A module of its own, not a test: worker processes import it by name (see conftest.py).
"""

from __future__ import annotations

import math
import os
import signal
import sys
import time
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    DetectionRow,
    EpisodeRow,
    Experiment,
    Measurement,
)

DIARY = "TINY_DIARY"
"""Environment variable: a file with a line for each time that a cell is begun."""


class _Record:
    """What of a SafetyRecord a run needs, without the planners' import time."""

    def __init__(self, scenario: str, intention: str, cost: float) -> None:
        self.facts: dict[str, Any] = {
            "scenario": scenario,
            "intention": intention,
            "outcome": "safe" if cost < 2 else "unplanned",
            "cost": cost if cost < 2 else None,
            "expanded": np.int64(100 * cost),
            "path_length": None,
            "travel_time": None,
            "reason": None if cost < 2 else "exhausted",
            "goal_occupied": None,
            "collision_time": None,
            "collision_object": None,
            "sm1_cost": None,
        }

    def to_json(self) -> dict[str, Any]:
        return self.facts


class Draws:
    """Numbers that follow from the seed and the cell."""

    def __init__(self, configuration: Configuration) -> None:
        self._seed = configuration.seed
        self._pause = float(configuration.options.get("pause", 0.0))
        self._hurry = Path(os.environ.get(DIARY, "") + ".hurry")

    def __call__(self, scenario: str, attack: str = "none") -> CellResult:
        _note(scenario, attack)
        generator = np.random.default_rng([self._seed, int(scenario), *attack.encode()])
        pause = self._pause * generator.uniform(0.5, 1.5)
        time.sleep(0.0 if self._hurry.exists() else pause)
        count = int(generator.integers(0, 3))
        boxes = Boxes3D(
            generator.normal(size=(count, 3)), generator.uniform(1, 2, (count, 3)),
            generator.normal(size=count), generator.uniform(size=count), ["Car"] * count,
        )  # fmt: skip
        cost = float(generator.uniform(1, 3))
        return CellResult(
            episodes=[
                EpisodeRow(attack, _Record(scenario, way, cost), strength=2)  # type: ignore[arg-type]
                for way in ("left", "right")
            ],
            detections=[DetectionRow(attack, scenario, boxes, strength=2)],
            measurements=[
                Measurement(attack, scenario, "loss", generator.normal()),
                Measurement(attack, scenario, "nothing", math.nan),
            ],
            seconds={"drawing": 0.25},
        )


class Trouble:
    """Does what its cell says."""

    def __init__(self, configuration: Configuration) -> None:
        self._repaired = Path(os.environ.get(DIARY, "") + ".repaired")

    def __call__(self, number: int, what: str) -> CellResult:
        _note(str(number), what)
        if self._repaired.exists():
            what = "fine"
        match what:
            case "data":
                raise DataError("the frame is dark.", path="000001.png")
            case "bug":
                raise ZeroDivisionError("a slip")
            case "exit":
                sys.exit("enough")
            case "leave":
                os._exit(7)
            case "killed":
                os.kill(os.getpid(), signal.SIGKILL)
            case "killed once":
                if _times(str(number), what) == 1:
                    os.kill(os.getpid(), signal.SIGKILL)
            case "no result":
                return None  # type: ignore[return-value]
            case "twins":
                return CellResult(measurements=[Measurement("twins", "0", "loss", 1.0)])
            case "warning":
                warnings.warn("something is odd", stacklevel=1)
        return CellResult(measurements=[Measurement(what, str(number), "loss", 1.0)])


class Threads:
    """How many threads the libraries of its process have, and which process it is."""

    def __init__(self, configuration: Configuration) -> None:
        import torch

        self._torch, self._made_in = torch, os.getpid()

    def __call__(self, number: int) -> CellResult:
        facts = {
            "torch": self._torch.get_num_threads(),
            "blas": int(os.environ["OPENBLAS_NUM_THREADS"]),
            "process": self._made_in,
        }
        return CellResult(
            measurements=[Measurement("", str(number), k, v) for k, v in facts.items()]
        )


def no_work(configuration: Configuration) -> Any:
    raise DataError("there are no weights.", path="dsgn.safetensors")


def deadly_work(configuration: Configuration) -> Any:
    os._exit(1)


def trouble(*what: str, name: str = "trouble", **options: Any) -> Experiment:
    place = "tiny_experiments:Trouble"
    cells = [Cell.of(place, number=number, what=each) for number, each in enumerate(what)]
    return Experiment(name, "What if?", "", lambda configuration: cells, options=options)


def only(place: str, count: int = 1) -> Experiment:
    cells = [Cell.of(f"tiny_experiments:{place}", number=number) for number in range(count)]
    return Experiment("only", "How?", "", lambda configuration: cells)


def _cells(configuration: Configuration, *attacks: str) -> list[Cell]:
    place = "tiny_experiments:Draws"
    return [
        Cell.of(place, f"{number:06d}", scenario=f"{number:06d}", attack=attack)
        for attack in attacks
        for number in range(configuration.limit or 10)
    ]


def _inputs(configuration: Configuration) -> Mapping[str, Path]:
    given = configuration.options["weights"]
    return {} if given is None else {"weights": Path(given)}


PRECISION = Experiment(
    "precision",
    "Does the detector still see?",
    "Figure 5.1",
    lambda configuration: _cells(configuration, "none", "weak"),
    _inputs,
    {"pause": 0.0, "weights": None},
)
SAFETY = Experiment(
    "safety",
    "Does the car still drive safely?",
    "Table 5.1",
    lambda configuration: _cells(configuration, "none", "strong"),
    options={"planner": "astar"},
)
TROUBLE = trouble("fine", "bug")


def _note(*words: str) -> None:
    if place := os.environ.get(DIARY):
        with open(place, "a") as file:
            file.write(" ".join([*words, str(os.getpid())]) + "\n")


def _times(*words: str) -> int:
    lines = Path(os.environ[DIARY]).read_text().splitlines()
    return sum(line.rpartition(" ")[0] == " ".join(words) for line in lines)
