"""The algorithms of stable-baselines3, and how a file spells their arguments."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Mapping
from importlib import import_module
from typing import Any

from avsec_gym.agents.argument_domains import check_widths, checked_argument
from avsec_gym.agents.extras import contributed

ALGORITHMS = {
    "ppo": "PPO",
    "a2c": "A2C",
    "sac": "SAC",
    "td3": "TD3",
    "ddpg": "DDPG",
    "dqn": "DQN",
    "tqc": "TQC",
    "trpo": "TRPO",
}
"""Names of classes, the last two of sb3-contrib."""
_CONTRIBUTED = ("TQC", "TRPO")
_POLICIES = {
    "AimingPolicy": "avsec_gym.agents.aiming_policy:AimingPolicy",
    "PlacePolicy": "avsec_gym.agents.place_policy:PlacePolicy",
}
"""Policies beside those of stable-baselines3."""
_ACTIVATIONS = ("ReLU", "Tanh", "ELU", "LeakyReLU", "SiLU", "GELU")
_GIVEN = ("self", "env", "policy", "seed", "device", "verbose", "tensorboard_log")
_OBJECTS = (
    "action_noise",
    "replay_buffer_class",
    "replay_buffer_kwargs",
    "rollout_buffer_class",
    "rollout_buffer_kwargs",
    "optimize_memory_usage",
)
"""Arguments that are objects, or that a checkpoint could not keep."""


def algorithm_class(name: str) -> Any:
    """The class of an algorithm, one of `ALGORITHMS`."""
    own = ALGORITHMS[name]
    if own in _CONTRIBUTED:
        return contributed(own)
    return getattr(import_module("stable_baselines3"), own)


def argument_names(name: str) -> list[str]:
    """What an entry may give to an algorithm, beside what the command gives."""
    signature = inspect.signature(algorithm_class(name).__init__)
    given = (*_GIVEN, *_OBJECTS, "stats_window_size", "_init_setup_model", "monitor_wrapper")
    return [argument for argument in signature.parameters if argument not in given]


def policy_named(name: str) -> Any:
    """The class of a policy of this package; else the name, which the algorithm knows."""
    if name not in _POLICIES:
        return name
    module, _, own = _POLICIES[name].partition(":")
    return getattr(import_module(module), own)


def plain_arguments(arguments: Mapping[str, Any], algorithm: str) -> dict[str, Any]:
    """Arguments of an entry as Python takes them.

    Args:
        arguments: Numbers, lists, and text: ``lin_0.001`` falls linearly to 0, ``dict(...)`` is a
            dictionary, ``nn.ReLU`` an activation.
        algorithm: The name of the algorithm.

    Raises:
        ConfigurationError, ValueError: The algorithm can do nothing with one of them.
    """
    return {name: _understood(name, value, algorithm) for name, value in arguments.items()}


def _understood(name: str, value: Any, algorithm: str) -> Any:
    if name != "policy_kwargs":
        return checked_argument(name, value, algorithm)
    value = _dictionary(value)
    if value.get("net_arch") is not None:
        check_widths(value["net_arch"])
    return {key: _activation(key, own) for key, own in value.items()}


def _dictionary(value: Any) -> dict[str, Any]:
    if isinstance(value, str):
        try:
            value = _literal(ast.parse(value.strip(), mode="eval").body)
        except (SyntaxError, TypeError, ValueError, RecursionError, MemoryError) as error:
            raise ValueError(f"policy_kwargs cannot be understood ({error})") from None
    if not isinstance(value, dict):
        raise ValueError(f"policy_kwargs is a mapping, not {value!r:.60}")
    return value


def _literal(node: ast.expr) -> Any:
    """The value of an expression of literals, ``dict(...)`` and names of activations."""
    if isinstance(node, ast.Call):
        if not isinstance(node.func, ast.Name) or node.func.id != "dict" or node.args:
            raise ValueError(f"nothing is called but dict(...): {ast.unparse(node)[:60]}")
        return {str(own.arg): _literal(own.value) for own in node.keywords}
    if isinstance(node, ast.Attribute | ast.Name):
        return ast.unparse(node)
    if isinstance(node, ast.List | ast.Tuple):
        return [_literal(item) for item in node.elts]
    if isinstance(node, ast.Dict):
        return {
            ast.literal_eval(key) if key is not None else None: _literal(item)
            for key, item in zip(node.keys, node.values, strict=True)
        }
    return ast.literal_eval(node)


def _activation(name: str, value: Any) -> Any:
    if name != "activation_fn":
        return value
    from torch import nn

    own = str(value).rpartition(".")[2]
    if own not in _ACTIVATIONS:
        raise ValueError(f"activation_fn is one of {', '.join(_ACTIVATIONS)}, not {value!r:.60}")
    return getattr(nn, own)
