"""The evidence of a run as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.shares import drive_of
from avsec_gym.experiments.chapter3.state_evidence_cells import bits, measured
from avsec_gym.experiments.results import Results
from avsec_gym.geometry import Floats
from avsec_gym.sensor_system import SensorSystem
from avsec_gym.validation.evidence import evidence_elements
from avsec_gym.validation.state_posterior import States, state_vectors


@dataclass(frozen=True, eq=False)
class EvidenceTable:
    """Of N moments in some states: all 2^(n+1), in the order of `state_vectors`, or `alone`.

    Args:
        system: Of sensors.
        moments: Their ids.
        shares: The evidence as of `gather_evidence`, shape (N, states, M).
        hole_shares: Of every triple, shape (N, states, triples).
    """

    system: SensorSystem
    moments: Sequence[str]
    shares: Floats
    hole_shares: Floats

    def __len__(self) -> int:
        return len(self.moments)

    @property
    def drives(self) -> list[str]:
        """Of each moment its drive."""
        return [drive_of(moment) for moment in self.moments]

    @property
    def measures(self) -> Floats:
        """All `MEASURES` of every triple, shape (N, states, triples, 4)."""
        place = {element: i for i, element in enumerate(evidence_elements(self.system))}
        columns = []
        for column, triple in enumerate(self.system.triples):
            pairs = [
                (one, triple[2]) for one in triple[:2] if ("brighter", (one, triple[2])) in place
            ]
            brightness = [
                self.shares[..., place["brighter", pair]] + self.shares[..., place["darker", pair]]
                for pair in pairs
            ]
            columns.append(
                [
                    self.shares[..., place["error", triple]],
                    self.hole_shares[..., column],
                    self.shares[..., place["densest", triple]],
                    np.max(brightness, axis=0),
                ]
            )
        return np.moveaxis(np.array(columns), (0, 1), (-2, -1))


def evidence_table(
    results: Results, kind: str, system: SensorSystem, states: States | None = None
) -> EvidenceTable:
    """Read what `StateEvidences` stored; moments that are not whole are left out.

    Args:
        results: Of a run.
        kind: Of attack: `FITTED`, `JUDGED`, or one of `BEYOND`.
        system: Of sensors.
        states: Shape (states, n + 1); None: all.

    Raises:
        ConfigurationError: There is none.
    """
    states = state_vectors(len(system)) if states is None else states
    elements = [measured(*element) for element in evidence_elements(system)]
    names = elements + [measured("hole_share", triple) for triple in system.triples]
    column = {name: number for number, name in enumerate(names)}
    found: dict[str, Floats] = {}
    for index, state in enumerate(states):
        for row in results.measurements(setting=f"{kind} {bits(state)}"):
            values = found.setdefault(row["scenario"], np.full((len(states), len(names)), np.nan))
            values[index, column[row["name"]]] = row["value"]
    whole = sorted(moment for moment, values in found.items() if np.isfinite(values).all())
    if not whole:
        raise ConfigurationError(
            f"the run has no moment of the kind {kind!r}: `avsec run identification` makes them"
        )
    stacked = np.stack([found[moment] for moment in whole])
    return EvidenceTable(
        system, whole, stacked[..., : len(elements)], stacked[..., len(elements) :]
    )
