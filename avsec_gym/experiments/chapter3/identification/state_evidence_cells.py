"""The evidence of all sensors in all states, frame by frame: the work of chapter 3."""

from __future__ import annotations

import time
from collections.abc import Iterable
from pathlib import Path
from typing import ClassVar

import numpy as np

from avsec_gym.experiments.chapter3.attacks import BEYOND, tampered_frames
from avsec_gym.experiments.chapter3.recordings import (
    FITTED,
    JUDGED,
    OPTIONS,
    SYSTEM,
    drives_inputs,
    frame_cells,
    recordings_of,
    seed_of,
)
from avsec_gym.runs.experiment import Cell, CellResult, Configuration, Measurement
from avsec_gym.sensor_system import SensorSystem
from avsec_gym.validation.evidence.evidence import EVIDENCE_FORMAT, evidence_elements
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.evidence.state_evidence import StateEvidence
from avsec_gym.validation.state_posterior import States, state_vectors

OF_TRIPLES = ("hole_share", "brightness")
"""Those of `MEASURES` that are no elements of the evidence."""

_WORK = f"{__name__}:StateEvidences"


def evidence_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every frame, first those that are fitted on."""
    return frame_cells(_WORK, configuration, (FITTED, JUDGED), format=EVIDENCE_FORMAT)


def evidence_inputs(configuration: Configuration) -> dict[str, Path]:
    """The manifests of procedural drives."""
    return drives_inputs(configuration, (FITTED, JUDGED))


class StateEvidences:
    """Attacks every sensor of a frame, and measures the evidence of every state.

    Args:
        configuration: The configuration of the run.
    """

    system: ClassVar[SensorSystem] = SYSTEM
    beyond: ClassVar[Iterable[str]] = tuple(BEYOND)

    def __init__(self, configuration: Configuration) -> None:
        options = {**OPTIONS, **configuration.options}
        self._depth = PairDepth(options["depth"])
        self._parts = {
            part: recordings_of(configuration, part, system=self.system)
            for part in (FITTED, JUDGED)
        }
        self._seeds = {part: seed_of(configuration, part) for part in (FITTED, JUDGED)}

    def __call__(self, part: str, number: int, format: int) -> CellResult:
        """The evidence of every state, and all `MEASURES` of its triples.

        Of a judged frame also the attacks that are ``beyond``, each on one sensor alone.

        Args:
            part: `FITTED` or `JUDGED`.
            number: The number of the frame.
            format: `EVIDENCE_FORMAT` of what is measured; cells of another one are done again.
        """
        recordings = self._parts[part]
        recorded, system = recordings.frames[number], recordings.system
        frame, seed = recorded.frame(), (self._seeds[part], number)
        every = state_vectors(len(system))
        kinds = {part: every}
        if part == JUDGED:
            kinds |= dict.fromkeys(self.beyond, alone(every))
        rows: list[Measurement] = []
        seconds: dict[str, float] = {}
        evidence = StateEvidence(frame, {}, system, self._depth)
        for kind, states in kinds.items():
            start = time.perf_counter()
            tampered = tampered_frames(frame, system, kind, seed)
            attacked = time.perf_counter()
            evidence = evidence.otherwise(
                {sensor: attacked_alone.frame for sensor, attacked_alone in tampered.items()}
            )
            rows += evidence_rows(evidence, kind, states, recorded.id)
            found = time.perf_counter()
            name = f"evidence of {len(states)} states"
            seconds["attack"] = seconds.get("attack", 0.0) + attacked - start
            seconds[name] = seconds.get(name, 0.0) + found - attacked
        return CellResult(measurements=rows, seconds=seconds)


def alone(states: States) -> States:
    """The states in which one sensor alone is attacked."""
    return np.asarray(states[states.sum(axis=1) == 1])


def bits(state: States) -> str:
    """A state vector as a word, S_0 first: ``0100``."""
    return "".join("1" if is_attacked else "0" for is_attacked in state)


def measured(name: str, scope: tuple[int, ...]) -> str:
    """The name of a share of some sensors in a run: ``error 0,1,3``."""
    return f"{name} {','.join(map(str, scope))}"


def evidence_rows(evidence: StateEvidence, kind: str, states: States, id: str) -> list[Measurement]:
    """What `evidence_table` reads.

    Args:
        evidence: The evidence of a frame under attacks of one kind.
        kind: The kind of attack.
        states: The states, shape (N, n + 1).
        id: The id of the frame.
    """
    rows = []
    elements = evidence_elements(evidence.system)
    for state, shares in zip(states, evidence.evidence(states), strict=True):
        setting = f"{kind} {bits(state)}"
        for (name, scope), share in zip(elements, shares, strict=True):
            rows.append(Measurement(setting, id, measured(name, scope), share))
        for triple, error in evidence.errors(state).items():
            # The shares of a triple that are no elements: those are counted by the map instead.
            for name in OF_TRIPLES:
                rows.append(Measurement(setting, id, measured(name, triple), getattr(error, name)))
    return rows
