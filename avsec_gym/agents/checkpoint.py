"""The state of a training as one file of safetensors: weights, optimisers, replay buffer."""

from __future__ import annotations

from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors.torch import save
from torch import Tensor

from avsec_gym.errors import DataError
from avsec_gym.perception.weights.tensor_files import read_tensors
from avsec_gym.storage.atomic_write import write_bytes

CHECKPOINT = "checkpoint.safetensors"
_STEPS, _SECONDS = "progress/steps", "progress/seconds"
_BUFFER, _POSITION = "replay/", "replay/position"
_ARRAYS = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
_ENTROPY = "log_ent_coef"
_SQUARES = ("exp_avg_sq", "max_exp_avg_sq", "square_avg", "step")
"""What optimisers take roots of, or divide by, and count."""
_LARGEST = 1e6
"""The largest weights, observations and rewards; a training whose numbers are larger has
diverged."""
_LARGEST_MEMORY = 1e15
"""The largest numbers of what an optimiser remembers: gradients, and their squares."""
_AGAIN = "Begin again in another folder: name another --out."


@dataclass(frozen=True)
class TrainingProgress:
    """How far a training is.

    Args:
        steps: Environment steps that were learned from.
        seconds: The time that took, all sittings together.
    """

    steps: int = 0
    seconds: float = 0.0


def write_checkpoint(folder: Path, learner: Any, progress: TrainingProgress) -> None:
    """Write where a training stands, over the last one."""
    tensors = {
        _STEPS: torch.tensor(progress.steps),
        _SECONDS: torch.tensor(progress.seconds, dtype=torch.float64),
    }
    for name, state in learner.get_parameters().items():
        tensors |= _optimiser(name, state) if "param_groups" in state else _prefixed(name, state)
    if (entropy := getattr(learner, _ENTROPY, None)) is not None:
        tensors[_ENTROPY] = entropy
    tensors |= _buffer(getattr(learner, "replay_buffer", None))
    # A copy each: safetensors refuses tensors that share their memory.
    content = save({name: value.detach().clone().contiguous() for name, value in tensors.items()})
    write_bytes(folder / CHECKPOINT, content, overwrite=True)


def is_finite(learner: Any) -> bool:
    """Whether all that was learned is a number: a training that has diverged cannot go on."""
    return all(bool(torch.isfinite(value).all()) for value in learner.policy.state_dict().values())


def read_checkpoint(folder: Path, learner: Any) -> TrainingProgress:
    """Put a fresh learner where a training stands.

    Raises:
        DataError: The file is missing, damaged, or of another configuration.
    """
    path = folder / CHECKPOINT
    tensors, _ = read_tensors(path, remedy=_AGAIN)
    if problem := misfit(tensors, learner):
        raise DataError(
            f"The checkpoint is damaged, or of another configuration: {problem}.",
            path=path,
            remedy=_AGAIN,
        )
    parameters = {
        name: _optimiser_state(name, state, tensors)
        if "param_groups" in state
        else {key: tensors[f"{name}/{key}"] for key in state}
        for name, state in learner.get_parameters().items()
    }
    learner.set_parameters(parameters, exact_match=True)
    if getattr(learner, _ENTROPY, None) is not None:
        learner.log_ent_coef.data.copy_(tensors[_ENTROPY])
    _fill_buffer(getattr(learner, "replay_buffer", None), tensors)
    progress = TrainingProgress(int(tensors[_STEPS]), float(tensors[_SECONDS]))
    learner.num_timesteps = progress.steps
    return progress


def misfit(tensors: dict[str, Tensor], learner: Any) -> str | None:
    """What keeps the tensors of a checkpoint from being one of a learner; None: nothing.

    Args:
        tensors: What the file holds.
        learner: A fresh one.
    """
    # What has to be there, by a checkpoint of the learner as it is.
    expected = {_STEPS: torch.tensor(0), _SECONDS: torch.tensor(0.0, dtype=torch.float64)}
    optimisers = {}
    for name, state in learner.get_parameters().items():
        if "param_groups" in state:
            optimisers[name] = attrgetter(name)(learner)
        else:
            expected |= _prefixed(name, state)
    if (entropy := getattr(learner, _ENTROPY, None)) is not None:
        expected[_ENTROPY] = entropy
    buffer = getattr(learner, "replay_buffer", None)
    if buffer is not None:
        position = tensors.get(_POSITION)
        if position is None or position.dtype != torch.int64 or position.shape != (2,):
            return f"{_POSITION} is missing or is no place in a buffer"
        place, full = position.tolist()
        if not 0 <= place < buffer.buffer_size or full not in (0, 1):
            return f"{_POSITION} is no place in the buffer"
        filled = buffer.buffer_size if full else place
        expected[_POSITION] = position
        for name, array in _arrays(buffer):
            expected[f"{_BUFFER}{name}"] = torch.from_numpy(array[:filled])
    # An optimiser remembers nothing of a parameter before its first step, then always the same.
    possible = dict(expected)
    for name, optimiser in optimisers.items():
        for index, state in _remembered(optimiser).items():
            own = _prefixed(f"{name}/{index}", state)
            possible |= own
            if any(key in tensors for key in own):
                expected |= own
    # What is there: all that is expected, nothing else, and numbers that a training can have.
    for key in expected:
        if key not in tensors:
            return f"{key} is missing"
    for key, value in tensors.items():
        if key not in possible:
            return f"{key} is none of its tensors"
        there = possible[key]
        if value.dtype != there.dtype or value.shape != there.shape:
            return (
                f"{key} is {value.dtype} {tuple(value.shape)}, not {there.dtype}"
                f" {tuple(there.shape)}"
            )
        if not torch.isfinite(value).all():
            return f"{key} holds numbers that are not finite"
        if key.rpartition("/")[2] in _SQUARES and value.numel() and value.min() < 0:
            return f"{key} holds squares below 0"
        is_remembered = key.partition("/")[0] in optimisers
        most = _LARGEST_MEMORY if is_remembered or key == _SECONDS else _LARGEST
        if value.is_floating_point() and value.numel() and value.abs().max() > most:
            return f"{key} holds numbers beyond {most:g}: the training has diverged"
    if int(tensors[_STEPS]) < 0 or float(tensors[_SECONDS]) < 0:
        return "it has gone on for less than no time"
    return None


def _remembered(optimiser: Any) -> dict[int, dict[str, Tensor]]:
    """What an optimiser remembers of each parameter after a step, as one of its kind shows."""
    groups = []
    for group in optimiser.param_groups:
        twins = [torch.zeros_like(p, requires_grad=True) for p in group["params"]]
        for twin in twins:
            twin.grad = torch.zeros_like(twin)
        groups.append({**group, "params": twins})
    twin = type(optimiser)(groups)
    twin.step()
    return {
        index: {key: torch.as_tensor(value) for key, value in state.items() if value is not None}
        for index, state in twin.state_dict()["state"].items()
    }


def _prefixed(name: str, state: Any) -> dict[str, Tensor]:
    return {f"{name}/{key}": value for key, value in state.items()}


def _optimiser(name: str, state: Any) -> dict[str, Tensor]:
    """What an optimiser remembers of each parameter; its settings are the configuration's."""
    return {
        f"{name}/{index}/{key}": torch.as_tensor(value)
        for index, own in state["state"].items()
        for key, value in own.items()
        if value is not None
    }


def _optimiser_state(name: str, fresh: Any, tensors: dict[str, Tensor]) -> dict[str, Any]:
    state: dict[int, dict[str, Tensor]] = {}
    for key, value in tensors.items():
        if key.startswith(f"{name}/"):
            index, _, own = key.removeprefix(f"{name}/").partition("/")
            state.setdefault(int(index), {})[own] = value
    return {"state": state, "param_groups": fresh["param_groups"]}


def _buffer(buffer: Any) -> dict[str, Tensor]:
    """The filled part of a replay buffer; observations may be dictionaries."""
    if buffer is None:
        return {}
    filled = buffer.size()
    found = {_POSITION: torch.tensor([buffer.pos, int(buffer.full)])}
    for name, array in _arrays(buffer):
        found[f"{_BUFFER}{name}"] = torch.from_numpy(np.ascontiguousarray(array[:filled]))
    return found


def _fill_buffer(buffer: Any, tensors: dict[str, Tensor]) -> None:
    if buffer is None:
        return
    for name, array in _arrays(buffer):
        stored = tensors[f"{_BUFFER}{name}"].numpy()
        array[: len(stored)] = stored
    position, full = tensors[_POSITION].tolist()
    buffer.pos, buffer.full = int(position), bool(full)


def _arrays(buffer: Any) -> list[tuple[str, Any]]:
    found: list[tuple[str, Any]] = []
    for name in _ARRAYS:
        value = getattr(buffer, name)
        if isinstance(value, dict):
            found += [(f"{name}/{key}", array) for key, array in value.items()]
        else:
            found.append((name, value))
    return found
