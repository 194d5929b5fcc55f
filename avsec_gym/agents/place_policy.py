"""`PlacePolicy`: scores each place of `avsec/GhostObject-v1` by the same small network."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium as gym
import torch
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from torch import nn

from avsec_gym.envs.ghost_round import SCENE_SIZE
from avsec_gym.envs.place_features import SIZE

CONSTRAINTS = 7
"""Numbers at an observation's beginning: speed, road type, intention, goal."""
_LAST_QUERY = 5


def places_in(observations: Any) -> Any:
    """Features of the places, shape (B, K, SIZE), of arrays and tensors alike.

    Args:
        observations: Observations of `avsec/GhostObject-v1`, shape (B, M).
    """
    rest = observations[:, SCENE_SIZE + _LAST_QUERY :]
    count = rest.shape[1] // (SIZE + 1)
    return rest[:, : count * SIZE].reshape(len(observations), count, SIZE)


class PlaceScores(BaseFeaturesExtractor):
    """A score of each place from its features and the driving constraints; one network for all.

    Args:
        observation_space: The observation space of `avsec/GhostObject-v1`.
        hidden: Width of both hidden layers.
    """

    def __init__(self, observation_space: gym.spaces.Box, hidden: int = 64) -> None:
        count = (observation_space.shape[0] - SCENE_SIZE - _LAST_QUERY) // (SIZE + 1)
        super().__init__(observation_space, features_dim=count)
        self.network = nn.Sequential(
            nn.Linear(SIZE + CONSTRAINTS, hidden),
            nn.ReLU(),
            nn.Linear(hidden, hidden),
            nn.ReLU(),
            nn.Linear(hidden, 1),
        )

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Scores less their mean, shape (B, K)."""
        places = places_in(observations)
        constraints = observations[:, None, :CONSTRAINTS].expand(-1, places.shape[1], -1)
        scores: torch.Tensor = self.network(torch.cat([places, constraints], dim=-1))[..., 0]
        return scores - scores.mean(dim=1, keepdim=True)


class PlacePolicy(ActorCriticPolicy):
    """The scores are the mean action: no layer that knows a place by its index.

    Args:
        arguments: Arguments of stable-baselines3's `ActorCriticPolicy`.
        named: Its arguments by name; the features extractor is `PlaceScores`.
    """

    def __init__(self, *arguments: Any, **named: Any) -> None:
        own: dict[str, Any] = {
            "features_extractor_class": PlaceScores,
            "share_features_extractor": False,
            "net_arch": [],
        }
        super().__init__(*arguments, **(own | named))

    def _build(self, lr_schedule: Callable[[float], float]) -> None:
        super()._build(lr_schedule)
        self.action_net = nn.Tanh()
        optimiser: Any = self.optimizer_class
        self.optimizer = optimiser(self.parameters(), lr=lr_schedule(1), **self.optimizer_kwargs)
