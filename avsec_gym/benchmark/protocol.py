"""What is done to each kind of entry: the pipeline's settings, the entered part in its place.

A detector is driven by as it is, under an attack that takes its own gradients where it has any,
under one that takes another detector's, and beside a printed patch that was trained against earlier
weights of both of the package's.  An attack is tried on both detectors of the package; a validator
on a camera and a LiDAR that light shines into, and where nothing does; a planner knows the truth.

What defends, a detector or a validator, is also attacked adaptively, on contested scenes: by an
attacker who tries more, and keeps what works best against this very part.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.argument_checks import place, shown
from avsec_gym.attacks.attacked_detector import attack_kind
from avsec_gym.attacks.patch_files import shipped_patch
from avsec_gym.benchmark.quiet_attacks import QUIETER
from avsec_gym.benchmark.scene_sets import CONTESTED
from avsec_gym.errors import AvsecError, ConfigurationError, DataError
from avsec_gym.kitti.detections import default_score_threshold
from avsec_gym.kitti.labels import read_detections
from avsec_gym.perception.detectors.detector import DifferentiableDetector
from avsec_gym.registry import Kind, check, kind_of, made_part, make
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.storage.regular_files import is_folder, is_there
from avsec_gym.validation.shipped import FitKind, shipped_file

DETECTORS = ("dsgn", "stereo_rcnn")
"""The detectors of the package that attacks are tried on, and whose gradients a stranger's attack
takes."""
PERTURBATION = {"name": "projected_pgd", "epsilon": 4.0, "steps": 7}
STRONGER = {**PERTURBATION, "steps": 12}
"""The same with more steps; the adaptive attack on a detector tries several, and keeps the worst.
More than these would take longer than an hour on two cores."""
UNATTACKED, WHITE_BOX, TRANSFERRED, PATCH = "unattacked", "white_box", "transferred", "patch"
ADAPTIVE = "adaptive"
"""A detector's setting, and what those of a validator end with before `VALIDATED`."""
TRUTH = "truth"
_AROUND = ("defended", "attacked")
"""Detectors around another one, which is what an attacker has to do with."""
VALIDATED = " validated"
"""What the names of a validator's settings end with where it stands before the detector."""
OPTICAL = {
    "facula": ("dsgn", {"name": "facula", "camera": 2}),
    "lidar_spoofing": ("pixor", {"name": "lidar_spoofing"}),
}
"""A validator's cases: the detector that the tampered sensor serves, and the attack on it."""


class Entered(StrEnum):
    """The part that an entry brings."""

    DETECTOR = "detector"
    ATTACK = "attack"
    VALIDATOR = "validator"
    PLANNER = "planner"

    @property
    def sees(self) -> bool:
        """Whether frames are needed, not the objects alone."""
        return self != Entered.PLANNER


@dataclass(frozen=True)
class Setting:
    """The pipeline as it is driven by once.

    Args:
        name: Name of the setting in an entry.
        parts: Arguments of `avsec_gym.pipeline.Pipeline`; None: the truth is planned on.
        planner: The planner.
        against: The setting that it is compared with, drive by drive; empty: none.
        attempts: Attacks that are tried after that of `parts`; the one under which most episodes
            collide without an alarm is kept, the first of equals.
    """

    name: str
    parts: Mapping[str, Any] | None
    planner: Any = "astar"
    against: str = ""
    attempts: Sequence[Any] = ()


def settings_of(kind: Entered, part: Any, scenes: str) -> list[Setting]:
    """The settings of an entry, in the order of its rows.

    Args:
        kind: What is entered.
        part: The part, by name or as a dictionary; of a detector also ``replayed``, whose folder
            holds one of KITTI result files for each setting, ``SCENES/SETTING``.
        scenes: Name of the set of scenes, which names such a folder.

    Raises:
        ConfigurationError: There is no such part.
        DataError: A folder of results is missing.
    """
    if kind == Entered.PLANNER:
        check(Kind.PLANNER, part)
        return [Setting(TRUTH, None, part)]
    if kind == Entered.ATTACK:
        check(attack_kind(part), part)
        return [
            setting
            for name in DETECTORS
            for setting in (
                Setting(name, {"detector": name}),
                Setting(f"{name} attacked", {"detector": name, "attack": part}, against=name),
            )
        ]
    if kind == Entered.VALIDATOR:
        part = _fitted(part)
        check(Kind.VALIDATOR, part)
        return _validated(part, scenes)
    check(Kind.DETECTOR, part)
    if is_replayed(part):
        return _of_results(results_of(part) / scenes)
    return _attacked(part, scenes)


def is_connected(kind: Entered, part: Any) -> bool:
    """Whether a validator is one of several vehicles, not of the sensors of one.

    Raises:
        ConfigurationError: There is no validator of that name.
    """
    kinds = (Kind.VALIDATOR, Kind.CONNECTED_VALIDATOR)
    return kind == Entered.VALIDATOR and kind_of(part, kinds) == Kind.CONNECTED_VALIDATOR


def is_replayed(part: Any) -> bool:
    """Whether a detector is known by its results alone."""
    return isinstance(part, Mapping) and part.get("name") == "replayed"


def is_white_box(part: Any) -> bool:
    """Whether an attack can take the gradients of a detector."""
    return isinstance(made_part("detector", Kind.DETECTOR, part), DifferentiableDetector)


def takes_gradients(attack: Any) -> bool | None:
    """Whether an attack climbs the loss of the detector that it meets: it knows a white box.

    Args:
        attack: The attack, by name or as a dictionary.

    Returns:
        None where there is no such attack here, as of a package that is not installed.
    """
    if isinstance(attack, Mapping) and attack.get("name") == PATCH:
        return False  # It was trained before; its file may be elsewhere.
    try:
        made = make(attack_kind(attack), attack)
    except AvsecError:
        return None
    return bool(getattr(made, "needs_gradient", False))


def results_of(part: Mapping[str, Any]) -> Path:
    """The folder of a detector that is known by its results alone.

    Raises:
        ConfigurationError: It is no folder's name, or the part has other arguments.
    """
    if set(part) != {"name", "detections"}:
        raise ConfigurationError(f"results are entered by their folder alone, got {shown(part)}")
    return place("detections", part["detections"])


def unknowing_attacks(part: Any) -> dict[str, dict[str, Any] | None]:
    """The attacks on a detector by who does not know it, by the names of their settings.

    Args:
        part: The detector.
    """
    of = DETECTORS[1] if _name(_innermost(part)) == DETECTORS[0] else DETECTORS[0]
    transferred = {"name": "transferred", "attack": PERTURBATION, "of": of}
    patch = {"name": "patch", "patch": str(shipped_patch("joint"))}
    return {UNATTACKED: None, TRANSFERRED: transferred, PATCH: patch}


def adaptive_attack(part: Any) -> dict[str, Any]:
    """The attack on a detector by who tries several, and asks it which one harms it most.

    More steps, begun twice by its own gradients if it gives any, and by those of the package's
    other detectors; of a defended one also by those of the network behind the defence, taken
    without it, which shows gradients that a defence obfuscates (Athalye et al. 2018).

    Args:
        part: The detector.
    """
    own = [STRONGER, STRONGER] if is_white_box(part) else []
    inner = _innermost(part)
    imitated = [inner] if inner != part and is_white_box(inner) else []
    imitated += [name for name in DETECTORS if name != _name(inner)]
    transferred = [{"name": "transferred", "attack": STRONGER, "of": each} for each in imitated]
    return {"name": "strongest", "attacks": [*own, *transferred]}


def _innermost(part: Any) -> Any:
    """The detector behind defences and attacks."""
    while isinstance(part, Mapping) and part["name"] in _AROUND:
        part = part["detector"]
    return part


def _name(part: Any) -> str:
    return part if isinstance(part, str) else str(part["name"])


def _attacked(part: Any, scenes: str) -> list[Setting]:
    attacks = unknowing_attacks(part)
    if is_white_box(part):
        attacks[WHITE_BOX] = {**PERTURBATION}
    if scenes == CONTESTED:
        attacks[ADAPTIVE] = adaptive_attack(part)
    return [
        Setting(name, {"detector": part, "attack": attack}, against=UNATTACKED if attack else "")
        for name, attack in attacks.items()
    ]


def _of_results(folder: Path) -> list[Setting]:
    """The settings that there are results of."""
    names = [name for name in (UNATTACKED, TRANSFERRED, PATCH) if is_folder(folder / name)]
    if UNATTACKED not in names:
        raise DataError(
            "There is no such folder of KITTI result files.",
            path=folder / UNATTACKED,
            remedy="`avsec benchmark frames --out DIR` writes the frames; a detector's results on"
            " DIR/SCENES/SETTING lie in SCENES/SETTING.",
        )
    # The scores of one detector are of one kind, attacked or not.
    scores = [read_detections(path).score for path in sorted((folder / UNATTACKED).glob("*.txt"))]
    threshold = default_score_threshold(np.concatenate([*scores, np.zeros(0)]))
    return [
        Setting(
            name,
            {
                "detector": {"name": "replayed", "detections": str(folder / name)},
                "score_threshold": threshold,
            },
            against=UNATTACKED if name != UNATTACKED else "",
        )
        for name in names
    ]


def _fitted(part: Any) -> Any:
    """A validator of the package with the fit that it ships for these frames, if it names none."""
    named = {"name": part} if isinstance(part, str) else dict(part)
    fits: dict[str, tuple[str, FitKind]] = {
        "thresholds": ("thresholds", "thresholds"),
        "likelihood": ("model", "likelihood"),
    }
    if named.get("name") not in fits:
        return part
    argument, kind = fits[named["name"]]
    return {argument: str(shipped_file(kind, SensorSystem((LIDAR, 3, 2)))), **named}


def _validated(part: Any, scenes: str) -> list[Setting]:
    cases: list[tuple[str, str, Any]] = [(UNATTACKED, DETECTORS[0], None)]
    cases += [(name, detector, attack) for name, (detector, attack) in OPTICAL.items()]
    settings = []
    for name, detector, attack in cases:
        plain = {"detector": detector, "attack": attack}
        validated = Setting(f"{name}{VALIDATED}", {**plain, "validator": part}, against=name)
        settings += [Setting(name, plain), validated]
        attempts = QUIETER.get(name, ()) if scenes == CONTESTED else ()
        if attempts:
            settings.append(
                replace(validated, name=adaptive(name), against=validated.name, attempts=attempts)
            )
    return settings


def adaptive(case: str) -> str:
    """The name of the setting in which a validator's case is attacked adaptively."""
    return f"{case} {ADAPTIVE}{VALIDATED}"


def places_in(value: Any) -> dict[str, Path]:
    """The files and folders that arguments of parts name, by their names."""
    if isinstance(value, Mapping):
        return {name: path for item in value.values() for name, path in places_in(item).items()}
    if isinstance(value, str) and os.sep in value and is_there(value):
        return {value: Path(value)}
    return {}
