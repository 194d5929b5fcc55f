"""What each argument of an algorithm can be: stable-baselines3 itself finds out while it trains."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from avsec_gym.argument_checks import flag, number, shown, whole_number
from avsec_gym.errors import ConfigurationError

SCHEDULE = "lin_"
"""``lin_0.001`` falls linearly from 0.001 to 0."""
_WHOLE: Mapping[str, tuple[int, int]] = {
    "n_steps": (1, 10**6),
    "batch_size": (1, 10**6),
    "n_epochs": (1, 10**4),
    "buffer_size": (1, 10**8),
    "learning_starts": (0, 10**9),
    "gradient_steps": (-1, 10**6),
    "target_update_interval": (1, 10**9),
    "policy_delay": (1, 10**6),
    "top_quantiles_to_drop_per_net": (0, 24),
    "cg_max_steps": (1, 10**4),
    "line_search_max_iter": (1, 10**4),
    "n_critic_updates": (1, 10**4),
    "sub_sampling_factor": (1, 10**4),
    "sde_sample_freq": (-1, 10**9),
}
_NUMBERS: Mapping[str, tuple[float, float]] = {
    "learning_rate": (0.0, 10.0),
    "gamma": (0.0, 1.0),
    "gae_lambda": (0.0, 1.0),
    "clip_range": (1e-9, 100.0),
    "clip_range_vf": (1e-9, 1e6),
    "ent_coef": (0.0, 100.0),
    "vf_coef": (0.0, 100.0),
    "max_grad_norm": (1e-9, 1e6),
    "target_kl": (1e-9, 1e6),
    "rms_prop_eps": (1e-30, 1.0),
    "tau": (0.0, 1.0),
    "target_entropy": (-1e6, 1e6),
    "target_policy_noise": (0.0, 100.0),
    "target_noise_clip": (0.0, 100.0),
    "exploration_fraction": (0.0, 1.0),
    "exploration_initial_eps": (0.0, 1.0),
    "exploration_final_eps": (0.0, 1.0),
    "cg_damping": (0.0, 100.0),
    "line_search_shrinking_factor": (1e-6, 1.0),
}
_FLAGS = ("normalize_advantage", "use_sde", "use_rms_prop", "use_sde_at_warmup")
_SCHEDULED = ("learning_rate", "clip_range", "clip_range_vf")
_MAY_LACK = ("clip_range_vf", "target_kl")
_AUTO: Mapping[str, tuple[str, ...]] = {
    "ent_coef": ("sac", "tqc"),
    "target_entropy": ("sac", "tqc"),
}
"""Arguments that these algorithms find by themselves: ``auto``, or ``auto_0.1`` from a start."""
_WIDEST = 16_384


def checked_argument(name: str, value: Any, algorithm: str) -> Any:
    """An argument as the algorithm takes it.

    Args:
        name: Name of the argument.
        value: The value as a file has it; a text may spell a number, as YAML reads 1e-3 as one.
        algorithm: The name of the algorithm.

    Returns:
        A number, a flag, a word, None, a pair of ``train_freq``, or a schedule.

    Raises:
        ConfigurationError: The algorithm can do nothing with it.
    """
    if value is None and name in _MAY_LACK:
        return None
    if isinstance(value, str):
        if name in _SCHEDULED and value.startswith(SCHEDULE):
            return _falling(name, value.removeprefix(SCHEDULE))
        if algorithm in _AUTO.get(name, ()) and _is_auto(name, value):
            return value
        value = _spelt(value)
    if name in _WHOLE:
        return whole_number(name, _without_point(value), *_WHOLE[name])
    if name in _NUMBERS:
        return number(name, value, *_NUMBERS[name])
    if name in _FLAGS:
        return flag(name, value)
    if name == "train_freq":
        return _train_freq(value)
    raise ConfigurationError(f"{name} is an argument that no configuration can give")


def check_widths(net_arch: Any) -> None:
    """Refuse layers of a network that are none.

    Args:
        net_arch: Widths as a list, or a dictionary of such by the network's part.

    Raises:
        ConfigurationError: Something else, or a layer too wide for any memory.
    """
    parts = net_arch.values() if isinstance(net_arch, dict) else [net_arch]
    for part in parts:
        if not isinstance(part, list) or len(part) > 100:
            raise ConfigurationError(f"net_arch is a list of widths, not {shown(part)}")
        for width in part:
            whole_number("a width of net_arch", width, 1, _WIDEST)


def _train_freq(value: Any) -> Any:
    """A number of steps, or such a number with ``step`` or ``episode``."""
    if not isinstance(value, list):
        return whole_number("train_freq", _without_point(value), 1, 10**9)
    if len(value) != 2 or value[1] not in ("step", "episode"):
        raise ConfigurationError(
            f"train_freq is a number, or [1, step] or [1, episode], not {value!r:.60}"
        )
    return whole_number("train_freq", value[0], 1, 10**9), value[1]


def _falling(name: str, text: str) -> Callable[[float], float]:
    start = _spelt(text)
    if not isinstance(start, float):
        raise ConfigurationError(f"{name} falls from a number, such as lin_0.001, not {text!r}")
    start = number(name, start, *_NUMBERS[name])
    return lambda remaining: remaining * start


def _is_auto(name: str, text: str) -> bool:
    if name != "ent_coef" or not text.startswith("auto_"):
        return text == "auto"
    start = _spelt(text.removeprefix("auto_"))
    return isinstance(start, float) and 0 < start <= _NUMBERS[name][1]


def _spelt(text: str) -> Any:
    try:
        return float(text) if "_" not in text else text
    except ValueError:
        return text


def _without_point(value: Any) -> Any:
    """1e6 as a whole number."""
    whole = isinstance(value, float) and math.isfinite(value) and value.is_integer()
    return int(value) if whole else value
