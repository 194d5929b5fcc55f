"""The state of a training in one file, written whole or not at all."""

from __future__ import annotations

import io
import json
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import torch
from torch import nn

from avsec_gym.errors import DataError
from avsec_gym.perception.training.curves import CURVES
from avsec_gym.perception.weights.state_dict import fit_state, problem_of_values
from avsec_gym.perception.weights.torch_files import read_torch_file
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.inert_pickle import unknown_parts
from avsec_gym.storage.json_files import parse_json
from avsec_gym.storage.portable_names import portable
from avsec_gym.storage.regular_files import is_there

CHECKPOINT = "checkpoint.pt"
"""Its name in the folder of a run."""

_LONGEST = 1e12
"""The longest of steps and of seconds, more than any training has."""
_FASTEST = 1e6
"""The fastest of learning rates: steps of patches are in grey levels."""
_DAMAGED = "It may be cut off or damaged; remove it to begin anew."
_OTHER_RUN = "Name another folder with --out, or remove this one."


@dataclass
class Checkpoint:
    """Where a training stands; random numbers follow from seed and step and need no place here.

    Args:
        identity: JSON-able: what the result depends on; a run goes on only under the same.
        step: Steps that were done.
        trained: State of the network and of whatever is learned with it; empty before a start.
        average: State of the average of the weights.
        optimizer: The optimizer's state.
        best: The highest leading metric so far.
        best_step: The step at which it was reached.
        without_better: Validations since then.
        validated: The step of the last validation.
        seconds: The seconds of training so far, validations included.
        compute_seconds: The seconds of steps alone.
        bfloat16: Whether the run calculates in bfloat16; None before the first step.
        arithmetic: Why, in words.
        finished: Whether there is nothing left to do.
    """

    identity: dict[str, Any]
    step: int = 0
    trained: dict[str, Any] = field(default_factory=dict)
    average: dict[str, Any] = field(default_factory=dict)
    optimizer: dict[str, Any] = field(default_factory=dict)
    best: float | None = None
    best_step: int = 0
    without_better: int = 0
    validated: int = 0
    seconds: float = 0.0
    compute_seconds: float = 0.0
    bfloat16: bool | None = None
    arithmetic: str = ""
    finished: bool = False


def save_checkpoint(folder: Path, checkpoint: Checkpoint) -> None:
    """Write it, over an earlier one.

    Raises:
        DataError: The folder cannot be written.
    """
    buffer = io.BytesIO()
    torch.save({item.name: getattr(checkpoint, item.name) for item in fields(checkpoint)}, buffer)
    write_bytes(folder / CHECKPOINT, buffer.getvalue(), overwrite=True)


def start_or_resume(folder: Path, identity: dict[str, Any], *, resume: bool) -> Checkpoint:
    """Where a training begins: at the last checkpoint of its folder, or at step 0.

    Args:
        folder: The folder of the run.
        identity: The identity of the training that begins.
        resume: Whether the run in the folder goes on, if there is one.

    Raises:
        DataError: The folder holds a training and `resume` is false; or its checkpoint is damaged,
            or belongs to another training, whose first difference is named.
    """
    identity = portable(identity)
    if resume:
        return _last(folder, identity) or Checkpoint(identity)
    if is_there(folder / CURVES):
        raise DataError(
            "A training is here already.",
            path=folder,
            remedy="Go on with it by --resume, or name another folder with --out.",
        )
    return Checkpoint(identity)


def resume_network(
    checkpoint: Checkpoint, network: nn.Module, folder: Path
) -> dict[str, torch.Tensor]:
    """Fill a network with the state of a checkpoint.

    Returns:
        The average of its weights.

    Raises:
        DataError: They are of another network; what differs is named.
    """
    path = folder / CHECKPOINT
    for state in (checkpoint.trained, checkpoint.average):
        if not all(isinstance(value, torch.Tensor) for value in state.values()):
            raise DataError("The checkpoint holds no weights.", path=path, remedy=_DAMAGED)
    network.load_state_dict(fit_state(checkpoint.trained, network, path))
    return fit_state(checkpoint.average, network, path)


def resume_optimizer(
    checkpoint: Checkpoint, optimizer: torch.optim.Optimizer, folder: Path
) -> None:
    """Let an optimizer go on from a checkpoint's state.

    Raises:
        DataError: Its state is that of another one.
    """
    path = folder / CHECKPOINT
    # What it remembers and its rate are the file's; its other settings are the configuration's.
    own = optimizer.state_dict()["param_groups"]
    try:
        there = _listed_groups(checkpoint.optimizer)
        groups = [
            {**mine, "lr": _rate(its["lr"]), "params": its["params"]}
            for mine, its in zip(own, there, strict=True)
        ]
        optimizer.load_state_dict({"state": checkpoint.optimizer["state"], "param_groups": groups})
    except (KeyError, TypeError, ValueError, AttributeError, RuntimeError) as error:
        raise DataError(
            f"The checkpoint is of another optimizer ({error}).", path=path, remedy=_DAMAGED
        ) from error
    for group in optimizer.param_groups:
        expected = _remembered(optimizer, group)
        for parameter in group["params"]:
            if problem := _problem_of_memory(optimizer.state[parameter], expected, parameter):
                raise DataError(f"The optimizer's {problem}.", path=path, remedy=_DAMAGED)


def _listed_groups(optimizer: dict[str, Any]) -> list[dict[str, Any]]:
    """The groups of an optimizer's state, and nothing else beside its memory."""
    state, groups = optimizer["state"], optimizer["param_groups"]
    if not (isinstance(state, dict) and isinstance(groups, list)):
        raise ValueError("it has no state and groups")
    if not all(isinstance(each, dict) for each in (*state.values(), *groups)):
        raise ValueError("its state or its groups are no dictionaries")
    return groups


def _rate(value: Any) -> float:
    if type(value) is not float or not 0 <= value <= _FASTEST:
        raise ValueError(f"its rate is {value!r:.40}")
    return value


def _remembered(
    optimizer: torch.optim.Optimizer, settings: dict[str, Any]
) -> dict[str, torch.Tensor]:
    """What an optimizer of this kind remembers of a weight of two numbers after a step."""
    weight = torch.zeros(2, requires_grad=True)
    weight.grad = torch.zeros(2)
    twin = type(optimizer)([{**settings, "params": [weight]}])  # type: ignore[call-arg]
    twin.step()
    return {
        name: value for name, value in twin.state[weight].items() if isinstance(value, torch.Tensor)
    }


def _problem_of_memory(
    memory: dict[str, Any], expected: dict[str, torch.Tensor], parameter: torch.Tensor
) -> str:
    """What keeps it from being that of a weight; empty if nothing, such as before a first step."""
    if not memory:
        return ""
    if set(memory) != set(expected):
        return f"memory holds {', '.join(map(str, memory)):.80}, expected {', '.join(expected)}"
    for name, value in memory.items():
        # Beside a value for each weight there are counters of steps.
        shape = parameter.shape if expected[name].ndim else torch.Size()
        if not isinstance(value, torch.Tensor) or not value.is_floating_point():
            return f"{name} is not what is written there"
        if value.shape != shape:
            return f"{name} has another shape than the weights"
        if problem := problem_of_values(value):
            return f"{name} holds a value that is {problem}"
        # Roots are taken of the one, and the other is divided by.
        if (name.endswith("_sq") and (value < 0).any()) or (name == "step" and value < 1):
            return f"{name} holds a value that is too small"
    return ""


def _last(folder: Path, identity: dict[str, Any]) -> Checkpoint | None:
    """The last checkpoint of a run; None where there is none yet."""
    path = folder / CHECKPOINT
    if not is_there(path):
        return None
    content = read_torch_file(path, remedy=_DAMAGED)
    if not (
        isinstance(content, dict) and set(content) == {item.name for item in fields(Checkpoint)}
    ):
        raise DataError("This is no checkpoint of a training.", path=path, remedy=_DAMAGED)
    if others := unknown_parts(content):
        raise DataError(
            f"The checkpoint holds something else than tensors and plain values ({others[0]}).",
            path=path,
            remedy=_DAMAGED,
        )
    checkpoint = Checkpoint(**content)
    if problem := _problem(checkpoint):
        raise DataError(f"The checkpoint's {problem}.", path=path, remedy=_DAMAGED)
    if difference := _difference(portable(checkpoint.identity), identity):
        raise DataError(
            f"The run here was begun with {difference}.", path=folder, remedy=_OTHER_RUN
        )
    return checkpoint


def _difference(old: Any, new: Any, name: str = "") -> str:
    """The first setting in which two descriptions differ, in words; empty if none."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in dict.fromkeys([*old, *new]):
            inner = _difference(old.get(key), new.get(key), f"{name}.{key}" if name else str(key))
            if inner:
                return inner
        return ""
    return "" if old == new else f"{name} {old!r}, this is {new!r}"


def _problem(checkpoint: Checkpoint) -> str:
    """What of a checkpoint is not of its type; empty if nothing."""
    for name in ("identity", "trained", "average", "optimizer"):
        value = getattr(checkpoint, name)
        if not (isinstance(value, dict) and all(isinstance(key, str) for key in value)):
            return f"{name} is no dictionary"
    for name in ("step", "best_step", "without_better", "validated"):
        value = getattr(checkpoint, name)
        if type(value) is not int or not 0 <= value < _LONGEST:
            return f"{name} is {value!r:.40}, expected a count"
    flags = (type(None), bool)
    if type(checkpoint.bfloat16) not in flags or type(checkpoint.arithmetic) is not str:
        return "arithmetic is not what a training writes"
    for name in ("best", "seconds", "compute_seconds"):
        value = getattr(checkpoint, name)
        # The leading metric of a training that failed is NaN.
        if type(value) not in (int, float) and not (name == "best" and value is None):
            return f"{name} is no number"
        if name != "best" and not 0 <= value < _LONGEST:
            return f"{name} is {value!r:.40}, expected seconds"
    try:
        parse_json(json.dumps(checkpoint.identity))
    except (TypeError, ValueError, RecursionError):
        return "identity is not what a training writes"
    return "finished is neither yes nor no" if type(checkpoint.finished) is not bool else ""
