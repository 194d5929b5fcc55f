"""``manifest.json`` of a run: what was asked, of which data, by which versions, when."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import fields
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.runs.experiment import Configuration, Experiment
from avsec_gym.runs.fingerprints import fingerprint
from avsec_gym.runs.renamed import EXPERIMENTS, PARTS, with_new_names
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.json_fields import fits, fitting_fields
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.regular_files import is_there

MANIFEST = "manifest.json"
"""Its name."""

_LOG = logging.getLogger(__name__)
_FORMAT_OF_OLD_NAMES, _FORMAT = 1, 2
_TRACKED = {"sources": "the sources", "versions": "the libraries", "python": "Python"}
_KIND = "avsec run"
_CONTENT: dict[str, Any] = {
    "started": str,
    "configuration": dict[str, Any],
    "threads": int,
    "experiments": dict[str, dict[str, str | None]],
    "inputs": dict[str, dict[str, str]],
    "sittings": list[dict[str, Any]],
}
_SITTING: dict[str, Any] = {
    "started": str,
    "ended": str | None,
    "versions": dict[str, str],
    "sources": str,
    "python": str,
    "platform": str,
    "processors": int | None,
}
_REMEDY = "Name another folder with --out; the same arguments go on with this run."


def new_manifest(
    experiments: Sequence[Experiment], configuration: Configuration, threads: int
) -> dict[str, Any]:
    """The manifest of a run that is about to begin; all inputs are read for their hashes.

    Raises:
        DataError: An input is not there.
    """
    inputs: dict[str, Path] = {}
    for experiment in experiments:
        inputs |= experiment.inputs(configuration)
    return {
        "kind": _KIND,
        "format": _FORMAT,
        "started": now(),
        "configuration": configuration.to_json(),
        "threads": threads,
        "experiments": {
            experiment.name: {
                "question": experiment.question,
                "thesis": experiment.thesis,
                "section": experiment.section,
            }
            for experiment in experiments
        },
        "inputs": {
            name: {"path": str(path), "sha256": fingerprint(path)} for name, path in inputs.items()
        },
        "sittings": [],
    }


def read_manifest(root: Path) -> dict[str, Any] | None:
    """A run's manifest, its experiments by their names of today; None where there is none.

    Raises:
        DataError: It cannot be read, or is not one of a run.
    """
    path = root / MANIFEST
    if not is_there(path):
        return None
    manifest = read_json_object(path, remedy="Name another folder.")
    if problem := _problem(manifest):
        raise DataError(
            f"This is no manifest of a run: {problem}.", path=path, remedy="Name another folder."
        )
    return _with_new_names(manifest)


def _with_new_names(manifest: dict[str, Any]) -> dict[str, Any]:
    """The manifest with today's names of experiments, and of parts in the options."""
    options = manifest["configuration"]["options"]
    if manifest["format"] == _FORMAT_OF_OLD_NAMES:
        for experiment in manifest["experiments"]:
            options = with_new_names(options, PARTS.get(experiment, {}))
    return {
        **manifest,
        "format": _FORMAT,
        "configuration": {**manifest["configuration"], "options": options},
        "experiments": {
            EXPERIMENTS.get(name, name): facts for name, facts in manifest["experiments"].items()
        },
    }


def _problem(manifest: Mapping[str, Any]) -> str:
    """What a manifest lacks, or has of another kind than it is; empty if nothing."""
    formats = (_FORMAT_OF_OLD_NAMES, _FORMAT)
    if manifest.get("kind") != _KIND or manifest.get("format") not in formats:
        return "it is of another kind, or format"
    if manifest["format"] is True:  # Which is 1 to Python.
        return "its format is no number"
    for name, kind in _CONTENT.items():
        if name not in manifest:
            return f"it lacks {name}"
        if not fits(manifest[name], kind):
            return f"its {name} {'is' if kind is int or kind is str else 'are'} of another kind"
    if not manifest["experiments"] or manifest["threads"] < 1:
        return "it has no experiments, or no threads"
    for values, names in (
        (manifest["inputs"].values(), ("path", "sha256")),
        (manifest["experiments"].values(), ("question", "thesis")),
    ):
        if not all(set(names) <= set(value) for value in values):
            return f"one of its entries lacks {' or '.join(names)}"
    for sitting in manifest["sittings"]:
        if not all(name in sitting and fits(sitting[name], _SITTING[name]) for name in _SITTING):
            return "one of its sittings lacks something, or has it of another kind"
    try:
        for time in (manifest["started"], *_times(manifest["sittings"])):
            if datetime.fromisoformat(time).tzinfo is None:
                raise ValueError("it has no time zone")
    except ValueError:
        return "one of its times is none"
    try:
        configuration = fitting_fields(Configuration, manifest["configuration"])
        if set(configuration) != set(manifest["configuration"]):
            return "its configuration has other fields"
        if lacking := {field.name for field in fields(Configuration)} - set(configuration):
            return f"its configuration lacks {min(lacking)}"
        Configuration(**configuration)
    except (ValueError, ConfigurationError) as error:
        return f"its configuration cannot be: {error}"
    return ""


def _times(sittings: Sequence[Mapping[str, Any]]) -> list[str]:
    return [
        sitting[name]
        for sitting in sittings
        for name in ("started", "ended")
        if sitting[name] is not None
    ]


def write_manifest(root: Path, manifest: Mapping[str, Any]) -> None:
    """Write it, over an earlier one."""
    text = json.dumps(manifest, indent=1, allow_nan=False) + "\n"
    write_bytes(root / MANIFEST, text.encode(), overwrite=True)


def check_same_question(
    root: Path, there: Mapping[str, Any], configuration: Configuration, threads: int
) -> None:
    """Check that what is asked now is what a run was asked; its inputs are not looked at.

    Args:
        root: Folder of the run.
        there: Manifest of the run.
        configuration: Asked now, with all options.
        threads: Asked now.

    Raises:
        DataError: Something that results depend on differs; it is named.
    """
    asked = configuration.to_json()
    _check_same(root, there["configuration"], asked, "scenarios", "limit", "seed")
    _check_same(root, there["configuration"]["options"], asked["options"])
    _check_same(root, there, {"threads": threads}, "threads")


def continued(root: Path, there: Mapping[str, Any], asked: Mapping[str, Any]) -> dict[str, Any]:
    """The manifest of a run that goes on, perhaps with further experiments.

    Args:
        root: Folder of the run.
        there: Manifest of the run.
        asked: A new one of what is asked now, see `check_same_question`.

    Raises:
        DataError: An input differs; it is named.
    """
    for name, (old, new) in _both(there["inputs"], asked["inputs"]).items():
        if old["sha256"] != new["sha256"]:
            raise DataError(
                f"The run here began with {name} from {old['path']} ({old['sha256'][:12]}); now it"
                f" is {new['path']} ({new['sha256'][:12]}), which holds something else.",
                path=root,
                remedy=_REMEDY,
            )
    options = there["configuration"]["options"] | asked["configuration"]["options"]
    return {
        **there,
        "configuration": {**there["configuration"], "options": options},
        "experiments": there["experiments"] | asked["experiments"],
        "inputs": asked["inputs"] | there["inputs"],
    }


def begin_sitting(manifest: dict[str, Any], environment: Mapping[str, Any]) -> dict[str, Any]:
    """Note in a manifest that work begins, here and with these versions; returns the note."""
    sittings = manifest["sittings"]
    if sittings:
        changed = [name for name in _TRACKED if sittings[-1].get(name) != environment[name]]
        if changed:
            _LOG.warning(
                "%s changed since this run was last worked on; its rows will be of both",
                " and ".join(_TRACKED[name] for name in changed),
            )
    sitting = {"started": now(), "ended": None, **environment}
    sittings.append(sitting)
    return sitting


def now() -> str:
    """The time in UTC, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def _check_same(
    root: Path, there: Mapping[str, Any], asked: Mapping[str, Any], *names: str
) -> None:
    for name, (old, new) in _both(there, asked).items():
        if old != new and (name in names or not names):
            raise DataError(
                f"The run here has {name} {json.dumps(old)}, asked is {json.dumps(new)}.",
                path=root,
                remedy=_REMEDY,
            )


def _both(there: Mapping[str, Any], asked: Mapping[str, Any]) -> dict[str, tuple[Any, Any]]:
    """What both know, by name: an experiment that joins a run brings options and inputs along."""
    return {name: (there[name], asked[name]) for name in asked if name in there}
