"""The state of a training as one file of safetensors: weights, optimisers, replay buffer."""

from __future__ import annotations

from dataclasses import dataclass
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
_AGAIN = "Begin again in another folder: name another --out."


@dataclass(frozen=True)
class Progress:
    """How far a training is.

    Args:
        steps: Environment steps that were learned from.
        seconds: The time that took, all sittings together.
    """

    steps: int = 0
    seconds: float = 0.0


def write_checkpoint(folder: Path, learner: Any, progress: Progress) -> None:
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


def read_checkpoint(folder: Path, learner: Any) -> Progress:
    """Put a fresh learner where a training stands.

    Raises:
        DataError: The file is missing, damaged, or of another configuration.
    """
    path = folder / CHECKPOINT
    tensors, _ = read_tensors(path, remedy=_AGAIN)
    try:
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
        progress = Progress(int(tensors[_STEPS]), float(tensors[_SECONDS]))
    except (KeyError, ValueError, RuntimeError, IndexError) as error:
        raise DataError(
            f"The checkpoint is of another configuration ({str(error)[:200]}).",
            path=path,
            remedy=_AGAIN,
        ) from error
    learner.num_timesteps = progress.steps
    return progress


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
        if len(stored) > len(array):
            raise ValueError(f"{len(stored)} transitions do not fit into {len(array)}")
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
