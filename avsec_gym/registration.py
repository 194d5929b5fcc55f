"""The catalogue of environments: id, entry points, arguments, longest episode."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import gymnasium as gym


@dataclass(frozen=True)
class EnvironmentEntry:
    """One environment of the catalogue."""

    id: str
    entry_point: str
    max_episode_steps: int | None
    """None: it ends by itself, always."""
    vector_entry_point: str | None = None
    kwargs: dict[str, Any] = field(default_factory=dict)


CATALOGUE = (
    EnvironmentEntry(
        id="avsec/GhostObject-v0",
        entry_point="avsec_gym.envs.ghost_object:GhostObjectEnv",
        max_episode_steps=10,
        vector_entry_point="avsec_gym.envs.ghost_object_vector:GhostObjectVectorEnv",
    ),
    EnvironmentEntry(
        id="avsec/GhostObject-v1",
        entry_point="avsec_gym.envs.ghost_place:GhostPlaceEnv",
        max_episode_steps=1,
        vector_entry_point="avsec_gym.envs.ghost_place_vector:GhostPlaceVectorEnv",
    ),
    EnvironmentEntry(
        id="avsec/DetectorBenchmark-v0",
        entry_point="avsec_gym.envs.detector_benchmark:DetectorBenchmarkEnv",
        max_episode_steps=None,  # One step.
    ),
    EnvironmentEntry(
        id="avsec/PerturbationAttack-v0",
        entry_point="avsec_gym.envs.perturbation_attack:PerturbationAttackEnv",
        max_episode_steps=10,
    ),
    EnvironmentEntry(
        id="avsec/PatchAttack-v0",
        entry_point="avsec_gym.envs.patch_attack:PatchAttackEnv",
        max_episode_steps=10,
    ),
    EnvironmentEntry(
        id="avsec/FaculaAttack-v0",
        entry_point="avsec_gym.envs.facula_attack:FaculaAttackEnv",
        max_episode_steps=10,
    ),
    EnvironmentEntry(
        id="avsec/LidarSpoofing-v0",
        entry_point="avsec_gym.envs.lidar_spoofing:LidarSpoofingEnv",
        max_episode_steps=10,
    ),
    EnvironmentEntry(
        id="avsec/SensorIdentification-v0",
        entry_point="avsec_gym.envs.sensor_identification:SensorIdentificationEnv",
        max_episode_steps=None,  # One step.
    ),
    EnvironmentEntry(
        id="avsec/ConnectedValidation-v0",
        entry_point="avsec_gym.envs.connected_validation:ConnectedValidationEnv",
        max_episode_steps=None,  # One step.
    ),
    EnvironmentEntry(
        id="avsec/ConnectedSpoofing-v0",
        entry_point="avsec_gym.envs.connected_spoofing:ConnectedSpoofingEnv",
        max_episode_steps=10,
    ),
    EnvironmentEntry(
        id="avsec/ClosedLoop-v0",
        entry_point="avsec_gym.envs.closed_loop:ClosedLoopEnv",
        max_episode_steps=None,  # Its own duration.
        vector_entry_point="avsec_gym.envs.closed_loop_vector:ClosedLoopVectorEnv",
    ),
    EnvironmentEntry(
        id="avsec/ClosedLoopAttack-v0",
        entry_point="avsec_gym.envs.closed_loop_attack:ClosedLoopAttackEnv",
        max_episode_steps=None,  # Its drive's duration.
        vector_entry_point=("avsec_gym.envs.closed_loop_attack_vector:ClosedLoopAttackVectorEnv"),
    ),
)


def register_environments() -> None:
    """Make every environment of the catalogue known to Gymnasium; a second call changes nothing."""
    for entry in CATALOGUE:
        if entry.id not in gym.registry:
            gym.register(
                id=entry.id,
                entry_point=entry.entry_point,
                max_episode_steps=entry.max_episode_steps,
                vector_entry_point=entry.vector_entry_point,
                kwargs=dict(entry.kwargs),
            )
