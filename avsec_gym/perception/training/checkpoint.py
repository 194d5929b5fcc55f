"""The state of a training in one file, written whole or not at all."""

from __future__ import annotations

import io
import pickle
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import torch

from avsec_gym.errors import DataError
from avsec_gym.kitti.atomic_write import write_bytes
from avsec_gym.perception.training.curves import CURVES

CHECKPOINT = "checkpoint.pt"
"""Its name in the folder of a run."""

_OTHER_RUN = "Name another folder with --out, or remove this one."


@dataclass
class Checkpoint:
    """Where a training stands; random numbers follow from seed and step and need no place here.

    Args:
        identity: JSON-able: what the result depends on; a run goes on only under the same.
        step: Steps that were done.
        trained: State of the network and of whatever is learned with it; empty before a start.
        average: State of the average of the weights.
        optimizer: Its state.
        best: The highest leading metric so far.
        best_step: When it was reached.
        without_better: Validations since then.
        seconds: Of training so far.
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
    seconds: float = 0.0
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
        folder: Of the run.
        identity: Of the training that begins.
        resume: Go on with the run in the folder, if there is one.

    Raises:
        DataError: The folder holds a training and `resume` is false; or its checkpoint is damaged,
            or belongs to another training, whose first difference is named.
    """
    if resume:
        return _last(folder, identity) or Checkpoint(identity)
    if (folder / CURVES).exists():
        raise DataError(
            "A training is here already.",
            path=folder,
            remedy="Go on with it by --resume, or name another folder with --out.",
        )
    return Checkpoint(identity)


def _last(folder: Path, identity: dict[str, Any]) -> Checkpoint | None:
    """The last checkpoint of a run; None where there is none yet."""
    path = folder / CHECKPOINT
    if not path.is_file():
        return None
    try:
        checkpoint = Checkpoint(**torch.load(path, map_location="cpu", weights_only=True))
    except (OSError, RuntimeError, TypeError, EOFError, pickle.UnpicklingError) as error:
        raise DataError(
            f"The checkpoint cannot be read ({_first_line(error)}).",
            path=path,
            remedy="Remove it to begin anew.",
        ) from error
    if difference := _difference(checkpoint.identity, identity):
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


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0]
