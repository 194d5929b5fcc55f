"""What drives on in closed loop for each kind of entry: a planner, or the errors of a detector.

No image is rendered: a detector stands in a drive by its error model, one for each attack on it.  A
planner knows the truth, and then has to do with the frozen errors of a detector of the package,
without an attack and beside a patch.  An attack is what it does to the errors of the package's
detectors.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from avsec_gym.argument_checks import shown
from avsec_gym.benchmark.loop_scenes import frozen_drives
from avsec_gym.benchmark.protocol import (
    DETECTORS,
    TRUTH,
    UNATTACKED,
    Entered,
    is_replayed,
    takes_gradients,
)
from avsec_gym.closed_loop.error_model.model import read_error_model
from avsec_gym.closed_loop.error_model.shipped import error_model_file, shipped_error_models
from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.weights.weights_file import weights_file_hash

REMEDY = (
    "fit one of its detections by `avsec error-model fit` and name it with --error-model, as"
    " docs/benchmark.md shows"
)


@dataclass(frozen=True)
class LoopSetting:
    """A car that drives on.

    Args:
        name: Name of the setting in an entry.
        perception: The argument of `avsec/ClosedLoop-v0`; an error model by its file.
        planner: The planner that replans.
        against: The setting that it is compared with, drive by drive; empty: none.
        attack: What the error model's card names as the attack; empty: none.
        white_box: Whether that attack takes the gradients of the detector that it meets; None:
            there is no attack, the entry is a planner, or it is not known.
    """

    name: str
    perception: str | Mapping[str, str]
    planner: Any = "astar"
    against: str = ""
    attack: Any = ""
    white_box: bool | None = None

    @property
    def model(self) -> Path | None:
        """The file of the error model; None: there is none."""
        return None if isinstance(self.perception, str) else Path(self.perception["model"])


class NoErrorModel(Exception):
    """Nothing stands for the part in a drive; the message is a sentence, with what to do."""


def loop_settings(kind: Entered, part: Any, models: Sequence[str] = ()) -> list[LoopSetting]:
    """The settings of an entry in closed loop, in the order of its rows.

    Args:
        kind: What is entered.
        part: The part, as of `avsec_gym.benchmark.protocol.settings_of`.
        models: Error models that were named: files, or names of shipped ones.

    Raises:
        NoErrorModel: There is no error model of it.
        ValueError: A validator.
        ConfigurationError: An error model is of another detector or attack.
        DataError: A file is missing or damaged.
    """
    if kind == Entered.PLANNER:
        return _of_planner(part)
    if kind == Entered.DETECTOR:
        return _of_detector(part, [_read(model) for model in models])
    if kind == Entered.ATTACK:
        return _of_attack(part, [_read(model) for model in models])
    raise ValueError("without images no validator has sensors to compare")


@dataclass(frozen=True)
class _Model:
    """An error model, and what its card names.

    Args:
        path: Its file.
        detector: The detector, by name or with arguments.
        attack: The attack likewise; empty: none.
        weights: Hash of the detector's weights; None: it is not known.
    """

    path: Path
    detector: Any
    attack: Any
    weights: str | None

    @property
    def name(self) -> str:
        """The name of its setting: the attack's."""
        if not self.attack:
            return UNATTACKED
        return str(_arguments(self.attack).get("name"))

    def setting(self, name: str, against: str = "") -> LoopSetting:
        """A car with these errors."""
        perception = {"name": "error_model", "model": str(self.path)}
        known = takes_gradients(self.attack) if self.attack else None
        return LoopSetting(name, perception, against=against, attack=self.attack, white_box=known)


def _of_planner(part: Any) -> list[LoopSetting]:
    cars = [LoopSetting(TRUTH, TRUTH, part)]
    for name, path in frozen_drives().error_models.items():
        perception = {"name": "error_model", "model": str(path)}
        attack = read_error_model(path).card.get("attack", "")
        cars.append(LoopSetting(name, perception, part, against=TRUTH, attack=attack))
    return cars


def _of_detector(part: Any, given: Sequence[_Model]) -> list[LoopSetting]:
    for model in given:
        _check_detector(model, part)
    models = given or _shipped_of(part)
    by_name: dict[str, _Model] = {}
    for model in models:
        if by_name.setdefault(model.name, model) is not model:
            raise ConfigurationError(f"--error-model: two are of {shown(model.name)}: name one")
    clean = by_name.pop(UNATTACKED, None)
    if clean is None and by_name:
        raise ConfigurationError(
            "--error-model: none is of the detector without an attack, which the others are"
            " compared with: name one"
        )
    if clean is None:
        raise NoErrorModel(f"there is no error model of {_named(part)}: {REMEDY}")
    attacked = [model.setting(name, UNATTACKED) for name, model in by_name.items()]
    return [clean.setting(UNATTACKED), *attacked]


def _of_attack(part: Any, given: Sequence[_Model]) -> list[LoopSetting]:
    for model in given:
        detector = _arguments(model.detector).get("name")
        if detector not in DETECTORS:
            raise ConfigurationError(
                f"{model.path} is of the detector {shown(detector)}: an attack meets"
                f" {' and '.join(DETECTORS)}"
            )
        if model.attack and _arguments(model.attack) != _arguments(part):
            raise ConfigurationError(
                f"{model.path} is of the attack {shown(model.attack)}, not of {shown(part)}"
            )
        _check_detector(model, model.detector)
    cars = []
    for detector in DETECTORS:
        # What was named comes first.
        models = [model for model in given if _arguments(model.detector)["name"] == detector]
        models += _shipped_of(detector)
        clean = next((model for model in models if not model.attack), None)
        attacked = (m for m in models if m.attack and _arguments(m.attack) == _arguments(part))
        under = next(attacked, None)
        if clean is not None and under is not None:
            cars += [clean.setting(detector), under.setting(f"{detector} attacked", detector)]
    if not cars:
        raise NoErrorModel(
            f"there are no error models of {' or '.join(DETECTORS)}, as their weights are today,"
            f" without and under {_named(part)}: {REMEDY}"
        )
    return cars


def _shipped_of(part: Any) -> list[_Model]:
    """The shipped error models that were fitted to a detector as it is today."""
    today = weights_file_hash(part)
    models = [_read(name) for name in shipped_error_models()]
    return [
        model
        for model in models
        if _arguments(model.detector) == _arguments(part) and model.weights == today
    ]


def _read(model: str) -> _Model:
    path = error_model_file(model).resolve()
    card = read_error_model(path).card
    attack = card.get("attack", "")
    return _Model(path, card.get("detector"), attack, card.get("weights"))


def _check_detector(model: _Model, part: Any) -> None:
    """Refuse an error model of something else than the entered detector.

    What is known by its results alone, or has no file of weights, is taken at its word.
    """
    if is_replayed(part):
        return
    if model.detector and _arguments(model.detector) != _arguments(part):
        raise ConfigurationError(
            f"{model.path} is of the detector {shown(model.detector)}, not of {shown(part)}"
        )
    today = weights_file_hash(part)
    if today is not None and model.weights is not None and model.weights != today:
        raise ConfigurationError(
            f"{model.path} was fitted to other weights of {_named(part)} ({model.weights[:8]}) than"
            f" it has now ({today[:8]}): fit it anew by `avsec error-model fit`"
        )


def _arguments(part: Any) -> dict[str, Any]:
    """A part with its arguments, however it was named."""
    return dict(part) if isinstance(part, Mapping) else {"name": part}


def _named(part: Any) -> str:
    return str(_arguments(part).get("name"))


def models_of(settings: Iterable[LoopSetting]) -> dict[str, Path]:
    """The files of the error models, by the names of their settings."""
    return {each.name: each.model for each in settings if each.model is not None}
