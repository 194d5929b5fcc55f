"""What all sensors say of each other in all states, moment by moment: the work of chapter 3."""

from __future__ import annotations

import time
from pathlib import Path

from avsec_gym.experiments.chapter3.attacks import tampered_frames
from avsec_gym.experiments.chapter3.recordings import FITTED, JUDGED, OPTIONS, recordings_of
from avsec_gym.experiments.experiment import Cell, CellResult, Configuration, Measurement
from avsec_gym.validation.evidence import evidence_scopes
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
        """E and hole share of every triple, and the unknown share of every map of two cameras."""
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
            for scope, share in zip(evidence_scopes(system), elements, strict=True):
                name = "error" if len(scope) == 3 else "unknown"
                rows.append(Measurement(setting, moment.id, f"{name} {_named(scope)}", share))
            for triple, error in evidence.errors(state).items():
                holes = f"hole_share {_named(triple)}"
                rows.append(Measurement(setting, moment.id, holes, error.hole_share))
        return CellResult(measurements=rows, seconds=seconds)


def bits(state: States) -> str:
    """A state vector as a word, S_0 first: ``0100``."""
    return "".join("1" if one else "0" for one in state)


def _named(scope: tuple[int, ...]) -> str:
    return ",".join(map(str, scope))
