"""What all sensors say of each other in all states, moment by moment: the work of chapter 3."""

from __future__ import annotations

import time
from pathlib import Path

from avsec_gym.experiments.chapter3.attacks import tampered_frames
from avsec_gym.experiments.chapter3.recordings import FITTED, JUDGED, OPTIONS, recordings_of
from avsec_gym.experiments.experiment import Cell, CellResult, Configuration, Measurement
from avsec_gym.validation.evidence import evidence_elements
from avsec_gym.validation.pair_depth import PairDepth
from avsec_gym.validation.state_evidence import StateEvidence
from avsec_gym.validation.state_posterior import States, state_vectors

_WORK = f"{__name__}:StateEvidences"


def evidence_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every moment, first those that are fitted on."""
    return [
        Cell.of(_WORK, moment.id.partition("/")[0], part=part, number=number)
        for part in (FITTED, JUDGED)
        for number, moment in enumerate(recordings_of(configuration, part).moments)
    ]


def evidence_inputs(configuration: Configuration) -> dict[str, Path]:
    """The manifests of procedural drives."""
    found = {}
    for part in (FITTED, JUDGED):
        manifest = recordings_of(configuration, part).root / "manifest.json"
        if manifest.is_file():
            found[f"{part} drives"] = manifest
    return found


class StateEvidences:
    """Attacks every sensor of a moment, and asks for the evidence of every state.

    Args:
        configuration: Of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        options = {**OPTIONS, **configuration.options}
        self._depth = PairDepth(options["depth"])
        self._parts = {part: recordings_of(configuration, part) for part in (FITTED, JUDGED)}
        self._seed = configuration.seed

    def __call__(self, part: str, number: int) -> CellResult:
        """The evidence of every state, and the hole shares of its triples."""
        recordings = self._parts[part]
        moment, system = recordings.moments[number], recordings.system
        seconds = {}
        start = time.perf_counter()
        frame = moment.frame()
        tampered = tampered_frames(frame, system, part, (self._seed, number))
        seconds["attack"] = time.perf_counter() - start
        start = time.perf_counter()
        frames = {sensor: one.frame for sensor, one in tampered.items()}
        evidence = StateEvidence(frame, frames, system, self._depth)
        states = state_vectors(len(system))
        shares = evidence.evidence(states)
        seconds["evidence"] = time.perf_counter() - start
        rows = []
        for state, elements in zip(states, shares, strict=True):
            setting = f"{part} {bits(state)}"
            for (name, scope), share in zip(evidence_elements(system), elements, strict=True):
                rows.append(Measurement(setting, moment.id, measured(name, scope), share))
            for triple, error in evidence.errors(state).items():
                # The one share of a triple that is no element: it is counted by the map instead.
                name = measured("hole_share", triple)
                rows.append(Measurement(setting, moment.id, name, error.hole_share))
        return CellResult(measurements=rows, seconds=seconds)


def bits(state: States) -> str:
    """A state vector as a word, S_0 first: ``0100``."""
    return "".join("1" if one else "0" for one in state)


def measured(name: str, scope: tuple[int, ...]) -> str:
    """What a share of some sensors is called in a run: ``error 0,1,3``."""
    return f"{name} {','.join(map(str, scope))}"
