"""Arguments of algorithms: what stable-baselines3 would only find out while it trains."""

from __future__ import annotations

import inspect
import math
from typing import Any

import pytest

from avsec_gym.agents.algorithms import ALGORITHMS, algorithm_class, argument_names, plain_arguments
from avsec_gym.agents.argument_domains import check_widths, checked_argument
from avsec_gym.errors import ConfigurationError
from tests.strange_values import STRANGE

PAIRS = [
    (algorithm, name)
    for algorithm in ALGORITHMS
    for name in argument_names(algorithm)
    if name != "policy_kwargs"
]
"""All that there are, so that an argument of a later release has to be thought of."""


@pytest.mark.parametrize(("algorithm", "name"), PAIRS)
def test_what_is_usual_is_taken(algorithm: str, name: str) -> None:
    usual = inspect.signature(algorithm_class(algorithm).__init__).parameters[name].default
    assert checked_argument(name, usual, algorithm) == usual


@pytest.mark.parametrize(("algorithm", "name"), PAIRS)
def test_what_is_strange_is_refused_or_becomes_a_plain_value(algorithm: str, name: str) -> None:
    messages = []
    for value in (*STRANGE, "lin_x", "lin_nan", "lin_inf", "lin_-1", "nan", "inf", "auto_-1"):
        try:
            found = checked_argument(name, value, algorithm)
        except ConfigurationError as error:
            messages.append(str(error))
            continue
        if callable(found):
            found = found(1.0)
        if isinstance(found, tuple):
            assert found[0] >= 1
            assert found[1] in ("step", "episode")
        elif found is not None and found != "auto":
            assert type(found) in (bool, int, float), value
            assert math.isfinite(found)
    assert len(messages) > 30
    assert all(name in message for message in messages)


@pytest.mark.parametrize(
    ("algorithm", "name", "text", "value"),
    [
        ("ppo", "learning_rate", "3e-4", 3e-4),
        ("ppo", "n_steps", 2048.0, 2048),
        ("sac", "buffer_size", "1e5", 100_000),
        ("sac", "train_freq", [1, "episode"], (1, "episode")),
        ("sac", "ent_coef", "auto_0.1", "auto_0.1"),
        ("sac", "target_entropy", "auto", "auto"),
    ],
)
def test_files_spell_them_as_rl_zoo3_does(algorithm: str, name: str, text: Any, value: Any) -> None:
    found = checked_argument(name, text, algorithm)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(("algorithm", "value"), [("ppo", "auto"), ("a2c", "auto_0.1")])
def test_only_some_find_their_entropy_themselves(algorithm: str, value: str) -> None:
    with pytest.raises(ConfigurationError, match="ent_coef takes a number"):
        checked_argument("ent_coef", value, algorithm)


@pytest.mark.parametrize(
    "net_arch", [3, "64", [64.0], [-1], [True], [10**9], {"pi": 3}, {"pi": [8], "vf": ["a"]}, [[8]]]
)
def test_layers_have_widths(net_arch: Any) -> None:
    with pytest.raises(ConfigurationError, match="net_arch"):
        check_widths(net_arch)
    with pytest.raises(ConfigurationError, match="net_arch"):
        plain_arguments({"policy_kwargs": {"net_arch": net_arch}}, "ppo")
