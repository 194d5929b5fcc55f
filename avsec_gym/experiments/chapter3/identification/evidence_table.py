"""The evidence of a run as arrays."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.identification.state_evidence_cells import (
    OF_TRIPLES,
    bits,
    measured,
)
from avsec_gym.geometry import Floats
from avsec_gym.runs.results import Results
from avsec_gym.sensor_system import SensorSystem
from avsec_gym.validation.evidence.disparity_error import MEASURES
from avsec_gym.validation.evidence.evidence import evidence_elements
from avsec_gym.validation.recordings import drive_of
from avsec_gym.validation.state_posterior import States, state_vectors


@dataclass(frozen=True, eq=False)
class EvidenceTable:
    """The evidence of N frames in some states: all 2^(n+1), as in `state_vectors`, or `alone`.

    Args:
        system: The sensors.
        frames: The frames' ids.
        shares: The evidence as of `gather_evidence`, shape (N, states, M).
        of_triples: `OF_TRIPLES` of every triple, shape (N, states, 2, triples).
    """

    system: SensorSystem
    frames: Sequence[str]
    shares: Floats
    of_triples: Floats

    def __len__(self) -> int:
        return len(self.frames)

    def without(self, frames: Container[str]) -> EvidenceTable:
        """The other frames."""
        kept = [i for i, id in enumerate(self.frames) if id not in frames]
        ids = [self.frames[i] for i in kept]
        return EvidenceTable(self.system, ids, self.shares[kept], self.of_triples[kept])

    @property
    def drives(self) -> list[str]:
        """The drive of each frame."""
        return [drive_of(id) for id in self.frames]

    @property
    def measures(self) -> Floats:
        """All `MEASURES` of every triple, shape (N, states, triples, 4)."""
        place = {element: i for i, element in enumerate(evidence_elements(self.system))}
        triples = self.system.triples
        found = {name: self.of_triples[..., i, :] for i, name in enumerate(OF_TRIPLES)}
        nothing = np.zeros(self.shares.shape[:2])
        for name in set(MEASURES) - set(OF_TRIPLES):
            where = [place.get((name, triple)) for triple in triples]
            of_each = [nothing if column is None else self.shares[..., column] for column in where]
            found[name] = np.stack(of_each, axis=-1)
        return np.stack([found[name] for name in MEASURES], axis=-1)


def evidence_table(
    results: Results, kind: str, system: SensorSystem, states: States | None = None
) -> EvidenceTable:
    """Read what `StateEvidences` stored; frames that are not whole are left out.

    Args:
        results: The results of a run.
        kind: The kind of attack: `FITTED`, `JUDGED`, or one of `BEYOND`.
        system: The sensors.
        states: The states, shape (states, n + 1); None: all.

    Raises:
        ConfigurationError: There is none.
    """
    states = state_vectors(len(system)) if states is None else states
    elements = [measured(*element) for element in evidence_elements(system)]
    names = elements + [measured(name, triple) for name in OF_TRIPLES for triple in system.triples]
    column = {name: number for number, name in enumerate(names)}
    found: dict[str, Floats] = {}
    for index, state in enumerate(states):
        for row in results.measurements(setting=f"{kind} {bits(state)}"):
            values = found.setdefault(row.scenario, np.full((len(states), len(names)), np.nan))
            if row.name in column:  # Others are of earlier versions.
                values[index, column[row.name]] = row.value
    whole = sorted(id for id, values in found.items() if np.isfinite(values).all())
    if not whole:
        raise ConfigurationError(
            f"the run has no whole frame of the kind {kind!r} of {len(system)} sensors: go on with"
            " the run that this report is of"
        )
    stacked = np.stack([found[id] for id in whole])
    of_triples = stacked[..., len(elements) :].reshape(*stacked.shape[:2], len(OF_TRIPLES), -1)
    return EvidenceTable(system, whole, stacked[..., : len(elements)], of_triples)
