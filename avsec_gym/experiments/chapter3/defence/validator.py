"""The validator of the experiment on defences, and what it was fitted on."""

from __future__ import annotations

import hashlib
import json
import logging
from functools import cache
from pathlib import Path

import avsec_gym
from avsec_gym import console
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.recordings import (
    FITTED,
    OPTIONS,
    check_parts,
    recordings_of,
)
from avsec_gym.registry import Kind, make
from avsec_gym.runs.experiment import Configuration
from avsec_gym.storage.folder_lock import folder_lock
from avsec_gym.storage.folders import make_folder
from avsec_gym.storage.regular_files import MAX_FILE_BYTES, read_bytes
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitting import CleanFrames, fit_threshold_table
from avsec_gym.validation.validator import Validator
from avsec_gym.world.export import cache_folder

VALIDATOR_OPTIONS = {**OPTIONS, "validator": "thresholds", "fitted_file": "", "rate": 0.01}
"""Options beside those of the recordings: ``validator``: ``thresholds`` or ``likelihood``;
``fitted_file``: what it was fitted to, thresholds of the clean drives to fit on if empty; ``rate``:
the designated false alarm rate r."""

_ARGUMENT = {"thresholds": "thresholds", "likelihood": "model"}
_LOG = logging.getLogger(__name__)


def defending_validator(configuration: Configuration) -> Validator:
    """The validator that the options name.

    Raises:
        ConfigurationError: There is none of that name, or it needs a file.
        DataError: The file is broken.
    """
    options = {**VALIDATOR_OPTIONS, **configuration.options}
    validator: Validator = make(
        Kind.VALIDATOR,
        {
            "name": options["validator"],
            _argument(options["validator"]): fitted_file(configuration),
            "rate": options["rate"],
        },
    )
    return validator


def fitted_file(configuration: Configuration) -> Path:
    """What the validator was fitted to; thresholds are measured on first use, and kept.

    Raises:
        ConfigurationError: No file is named, and thresholds are not what is needed; or the drives
            to fit on are of another rig, or those to judge.
        DataError: The drives to fit on are not there, or the cache cannot be written.
    """
    options = {**VALIDATOR_OPTIONS, **configuration.options}
    if options["fitted_file"]:
        return Path(options["fitted_file"])
    if _argument(options["validator"]) != "thresholds":
        raise ConfigurationError(
            f"the validator {options['validator']!r} needs a fit: --options fitted_file=FILE"
        )
    check_parts(configuration)
    recordings, depth = recordings_of(configuration, FITTED), PairDepth(options["depth"])
    names = [recorded.id for recorded in recordings.frames]
    known = [str(recordings.root.resolve()), recordings.system.sensors, depth.settings, names]
    key = hashlib.sha256(f"{_sources()} {json.dumps(known)}".encode()).hexdigest()[:16]
    folder = cache_folder() / "thresholds"
    make_folder(folder)
    path = folder / f"{key}.json"
    with folder_lock(folder, wait=True, what="a validator's thresholds"):
        if not path.is_file():
            _LOG.warning("measuring thresholds on %d clean frames, once", len(names))
            data = {"recordings": recordings.root.name}
            clean = CleanFrames(recordings.frames, recordings.system, depth, data)
            samples = folder / f"{key}.samples.jsonl"
            with console.progress("measuring clean frames") as shown:
                table = fit_threshold_table(clean, samples=samples, on_progress=shown)
            table.write(path)
            samples.unlink()
    return path


@cache
def _sources() -> str:
    """Changes with whatever thresholds depend on, so that none are kept beyond their time."""
    digest = hashlib.sha256()
    root = Path(avsec_gym.__file__).parent
    for pattern in ("validation/**/*.py", "perception/depth/**/*.py", "*.py"):
        for path in sorted(root.glob(pattern)):
            digest.update(read_bytes(path, most=MAX_FILE_BYTES))
    return digest.hexdigest()


def _argument(validator: str) -> str:
    if validator not in _ARGUMENT:
        known = " or ".join(_ARGUMENT)
        raise ConfigurationError(f"a validator of a defence is {known}, got {validator!r}")
    return _ARGUMENT[validator]
