"""Procedural drives of KITTI's rig, the evidence of its sensors there, and of fewer sensors.

Everything is measured once, of the LiDAR and three cameras in every state; the
evidence of fewer sensors is a part of that.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.recordings import FITTED, JUDGED
from avsec_gym.geometry import Floats
from avsec_gym.sensor_system import KITTI_SYSTEM, SensorSystem
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.evidence import EVIDENCE_FORMAT, evidence_elements
from avsec_gym.validation.evidence.state_evidence import StateEvidence
from avsec_gym.validation.state_posterior import States, state_indices, state_vectors
from avsec_gym.world.assets import Assets
from avsec_gym.world.export import Sensors, cached, suite_recipe

SYSTEM = KITTI_SYSTEM
"""All sensors that are rendered."""

_FIRST_SET = {FITTED: 5000, JUDGED: 6000}
"""Numbers of the sets of drives, none of which anything else was made from."""
PART_ASSETS = {FITTED: Assets.TRAIN, JUDGED: Assets.JUDGE}
"""What is judged shares no car, house, tree or texture with what was fitted on."""


@dataclass(frozen=True, eq=False)
class SystemEvidence:
    """The evidence of the sensors of a system in N frames, in K states.

    Args:
        system: The sensors.
        states: Shape (K, n + 1).
        shares: `MEASURES` of every triple, shape (N, K, triples, 4).
        elements: Elements as of `gather_evidence`, shape (N, K, M).
    """

    system: SensorSystem
    states: States
    shares: Floats
    elements: Floats

    def of(self, system: SensorSystem) -> SystemEvidence:
        """The evidence of some of the sensors, in the states that attack no other sensor.

        Args:
            system: Some of the sensors, in the same order.

        Raises:
            ConfigurationError: It has sensors that are not there.
        """
        if not set(system.sensors) <= set(self.system.sensors):
            raise ConfigurationError(f"{system.sensors} are not all among {self.system.sensors}")
        place = [self.system.sensors.index(sensor) for sensor in system.sensors]
        others = np.setdiff1d(np.arange(len(self.system)), place)
        kept = ~self.states[:, others].any(axis=1)
        triples = [self.system.triples.index((place[i], place[j], place[k])) for i, j, k in
                   system.triples]  # fmt: skip
        column = {element: number for number, element in enumerate(evidence_elements(self.system))}
        columns = [
            column[name, tuple(place[position] for position in scope)]
            for name, scope in evidence_elements(system)
        ]
        states = self.states[kept][:, place]
        # In the order of `state_vectors`, where all of them are there.
        order = np.argsort(state_indices(states), kind="stable")
        return SystemEvidence(
            system,
            states[order],
            self.shares[:, kept][:, order][:, :, triples],
            self.elements[:, kept][:, order][:, :, columns],
        )


def shipped_drives(count: int, seed: int, part: str, assets: Assets | None = None) -> Path:
    """Cameras 1, 2 and 3 of KITTI's rig and its LiDAR, each frame a drive of its own.

    Made in the user's cache on first use.

    Args:
        count: The number of frames.
        seed: Seed of the drives; other seeds are other drives.
        part: `FITTED` or `JUDGED`, which never share a drive.
        assets: The part of the assets that they are made of; None: `PART_ASSETS` has it.

    Raises:
        ConfigurationError: There cannot be so many, or the seed is not from 0 to 999.
        DataError: The cache cannot be written.
    """
    if not 0 <= seed < 1000:
        raise ConfigurationError(f"a seed of drives is from 0 to 999, got {seed}")
    assets = PART_ASSETS[part] if assets is None else assets
    recipe = suite_recipe(
        "raw",
        count,
        _FIRST_SET[part] + seed,
        sensors=Sensors(cameras=(1, 2, 3)),
        drive_frames=1,
        assets=assets,
    )
    return cached(f"shipped_fits-{part}-{seed}-{count}-{assets}", recipe)


def sample_id(id: str, seed: int, part: str) -> str:
    """The id of a frame where its evidence is kept.

    Another format, other assets or another seed give another id.
    """
    return f"{EVIDENCE_FORMAT}/{PART_ASSETS[part]}/{seed}/{id}"


def measured(evidence: StateEvidence, states: States) -> Floats:
    """The evidence of a frame, as one row: `MEASURES` of all triples, then the evidence, by state.

    Args:
        evidence: The evidence of the frame.
        states: Shape (K, n + 1).

    Returns:
        Shape (K, triples * 4 + M).
    """
    rows = []
    for state, elements in zip(states, evidence.evidence(states), strict=True):
        errors: DisparityErrors = evidence.errors(state)
        shares = np.concatenate([errors[triple].shares for triple in errors])
        rows.append(np.r_[shares, elements])
    return np.asarray(np.round(rows, 6), float)


def evidence_of(rows: Floats, system: SensorSystem, states: States | None = None) -> SystemEvidence:
    """Rows of `measured` taken apart.

    Args:
        rows: Rows of N frames, shape (N, K, any).
        system: The sensors.
        states: The states in which they are; None: all.
    """
    states = state_vectors(len(system)) if states is None else states
    shares = 4 * len(system.triples)
    return SystemEvidence(
        system,
        states,
        rows[..., :shares].reshape(*rows.shape[:2], len(system.triples), 4),
        rows[..., shares:],
    )
