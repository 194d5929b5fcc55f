"""``manifest.json`` of a run: what was asked, of which data, by which versions, when."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import fields
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypedDict, cast

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.runs.experiment import Configuration, Experiment
from avsec_gym.runs.fingerprints import Environment, fingerprint
from avsec_gym.runs.renamed import EXPERIMENTS, PARTS, with_new_names
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.json_fields import check_fields, fitting_fields
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.portable_names import local, portable
from avsec_gym.storage.regular_files import is_there

MANIFEST = "manifest.json"
"""Its name."""

_LOG = logging.getLogger(__name__)
_FORMAT_OF_OLD_NAMES, _FORMAT = 1, 2
_TRACKED = {"sources": "the sources", "versions": "the libraries", "python": "Python"}
_KIND = "avsec run"
_REMEDY = "Name another folder with --out; the same arguments go on with this run."


class _Section(TypedDict, total=False):
    section: str | None
    """Section of runs of this release."""


class Asked(_Section):
    """An experiment of the run, see `Experiment`."""

    question: str
    thesis: str


class Input(TypedDict):
    """What results depend on, and its hash."""

    path: str
    sha256: str


class _Work(TypedDict, total=False):
    command: str
    workers: int
    backend: str
    done: int
    failed: int
    """Numbers of cells, once it has ended."""


class Sitting(Environment, _Work):
    """A time of work on the run; ``ended`` is None while it goes on, or where it was killed."""

    started: str
    ended: str | None


class Manifest(TypedDict):
    """The file's content: inputs and experiments by their names, times in UTC."""

    kind: str
    format: int
    started: str
    configuration: dict[str, Any]
    """Fields of `Configuration`."""
    threads: int
    """Threads of each process."""
    experiments: dict[str, Asked]
    inputs: dict[str, Input]
    sittings: list[Sitting]


def new_manifest(
    experiments: Sequence[Experiment], configuration: Configuration, threads: int
) -> Manifest:
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
            name: {"path": _from_here(path), "sha256": fingerprint(path)}
            for name, path in inputs.items()
        },
        "sittings": [],
    }


def _from_here(path: Path) -> str:
    """A path from the working folder where it lies below that: it holds in another clone, too."""
    whole, here = path.absolute(), Path.cwd()
    return str(whole.relative_to(here)) if whole.is_relative_to(here) else str(path)


def read_manifest(root: Path) -> Manifest | None:
    """A run's manifest, its experiments by their names of today; None where there is none.

    Raises:
        DataError: It cannot be read, or is not one of a run.
    """
    path = root / MANIFEST
    if not is_there(path):
        return None
    manifest: Any = read_json_object(path, remedy="Name another folder.")
    if problem := _problem(manifest):
        raise DataError(
            f"This is no manifest of a run: {problem}.", path=path, remedy="Name another folder."
        )
    return _with_new_names(local(manifest))


def _with_new_names(manifest: Manifest) -> Manifest:
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
    try:
        check_fields(Manifest, manifest)
    except ValueError as error:
        return str(error)
    if not manifest["experiments"] or manifest["threads"] < 1:
        return "it has no experiments, or no threads"
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


def _times(sittings: Sequence[Sitting]) -> list[str]:
    times = [time for sitting in sittings for time in (sitting["started"], sitting["ended"])]
    return [time for time in times if time is not None]


def write_manifest(root: Path, manifest: Manifest) -> None:
    """Write it, over an earlier one."""
    text = json.dumps(portable(manifest), indent=1, allow_nan=False) + "\n"
    write_bytes(root / MANIFEST, text.encode(), overwrite=True)


def check_same_question(
    root: Path, there: Manifest, configuration: Configuration, threads: int
) -> None:
    """Check that what is asked now is what a run was asked; its inputs are not looked at.

    Args:
        root: Folder of the run.
        there: Manifest of the run.
        configuration: The configuration that is asked for now, with all options.
        threads: The number of threads that is asked for now.

    Raises:
        DataError: Something that results depend on differs; it is named.
    """
    asked = configuration.to_json()
    _check_same(root, there["configuration"], asked, "scenarios", "limit", "seed")
    _check_same(root, there["configuration"]["options"], asked["options"])
    _check_same(root, there, {"threads": threads}, "threads")


def continued(root: Path, there: Manifest, asked: Manifest) -> Manifest:
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


def begin_sitting(manifest: Manifest, environment: Environment) -> Sitting:
    """Note in a manifest that work begins, here and with these versions; returns the note."""
    sittings = manifest["sittings"]
    if sittings:
        last, today = dict(sittings[-1]), dict(environment)
        changed = [name for name in _TRACKED if last[name] != today[name]]
        if changed:
            _LOG.warning(
                "%s changed since this run was last worked on; its rows will be of both",
                " and ".join(_TRACKED[name] for name in changed),
            )
    sitting = cast("Sitting", {"started": now(), "ended": None, **environment})
    sittings.append(sitting)
    return sitting


def now() -> str:
    """The time in UTC, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def _check_same(
    root: Path, there: Mapping[str, Any], asked: Mapping[str, Any], *names: str
) -> None:
    for name, (old, new) in _both(portable(there), portable(asked)).items():
        if old != new and (name in names or not names):
            raise DataError(
                f"The run here has {name} {json.dumps(old)}, asked is {json.dumps(new)}.",
                path=root,
                remedy=_REMEDY,
            )


def _both(there: Mapping[str, Any], asked: Mapping[str, Any]) -> dict[str, tuple[Any, Any]]:
    """What both know, by name: an experiment that joins a run brings options and inputs along."""
    return {name: (there[name], asked[name]) for name in asked if name in there}
