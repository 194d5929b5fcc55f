"""The settings of `avsec drive`: those that its options ask for, known ones by name, own ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from avsec_gym.commands.named_part import named_part
from avsec_gym.drives.setting import DriveSetting, check_names
from avsec_gym.envs.drivers import PLANNER
from avsec_gym.errors import ConfigurationError
from avsec_gym.suggestions import unknown_name

TRUTH, BLIND, ERROR_MODEL = "truth", "blind", "error-model"
DETECTOR, ATTACKED, DEFENDED = "detector", "attacked", "defended"
LIDAR, STEREO = "lidar", "stereo"
DRIVER = "driver"
KNOWN = (TRUTH, BLIND, ERROR_MODEL, LIDAR, STEREO, DETECTOR, ATTACKED, DEFENDED)


@dataclass(frozen=True)
class DriveParts:
    """The parts that options name.

    Args:
        detector: The detector; None: the environment's own.
        attack: The attack; None: none is named.
        validator: The validator; None: none is named.
        error_model: The files, or names, of error models.
        sensing: Other arguments of cars with sensors, such as a classifier.
        shared: Arguments of every setting, such as the planner, and its `driver`.
        defended: Other arguments of the defended car, such as its handover.
    """

    detector: Any = None
    attack: Any = None
    validator: Any = None
    error_model: Sequence[str] = ()
    sensing: Mapping[str, Any] | None = None
    shared: Mapping[str, Any] | None = None
    defended: Mapping[str, Any] | None = None

    def settings(self, asked: tuple[str, ...]) -> list[DriveSetting]:
        """The settings by what was typed; none: all that the parts suffice for.

        Args:
            asked: Names of `KNOWN`, or JSON with a ``name`` and arguments of the environment.

        Raises:
            ConfigurationError: A name is unknown, two are equal, or a part is missing.
        """
        typed = [named_part(text, "--settings") for text in asked or self._usual()]
        found = [setting for what in typed for setting in self._settings_of(what)]
        check_names(found)
        self._check_used(found, typed)
        return found

    def _check_used(self, found: Sequence[DriveSetting], typed: Sequence[Any]) -> None:
        """That every part that an option names is a part of some setting.

        Raises:
            ConfigurationError: One is not.
        """
        used = {name for setting in found for name in setting.arguments}
        if ERROR_MODEL in typed:
            used.add("error_model")
        for part in self._given():
            if part not in used:
                raise ConfigurationError(
                    f"--{part.replace('_', '-')} is used by none of the settings"
                    f" {' '.join(setting.name for setting in found)}:"
                    f" add {_SETTING_WITH[part]}, or leave it out"
                )

    def _given(self) -> list[str]:
        """Parts that options name and only some settings have."""
        own = ("detector", "attack", "validator", "error_model")
        return [
            *(self.sensing or {}),
            *(self.defended or {}),
            *(part for part in own if getattr(self, part)),
        ]

    def _usual(self) -> list[str]:
        names = [TRUTH, BLIND]
        names += [ERROR_MODEL] if self.error_model else []
        if set(self._given()) - {"error_model"}:
            names.append(DETECTOR)
        names += [ATTACKED] if self.attack is not None else []
        names += [DEFENDED] if self.validator is not None else []
        return names

    def _settings_of(self, what: Any) -> list[DriveSetting]:
        """One setting; of several error models, one of each."""
        if what != ERROR_MODEL or len(self.error_model) < 2:
            return [self._setting(what)]
        return [self._made(Path(model).stem, _believing(model)) for model in self.error_model]

    def _made(self, name: str, own: Mapping[str, Any]) -> DriveSetting:
        """The setting of a name, with what all have."""
        arguments = {**(self.shared or {}), **own}
        if own.get("classifier") is not None and "motion" not in own:
            arguments.pop("motion", None)  # That of all other settings.
        driver = arguments.pop(DRIVER, PLANNER)
        return DriveSetting(name, arguments, driver)

    def _setting(self, what: Any) -> DriveSetting:
        if isinstance(what, Mapping):
            own = {key: value for key, value in what.items() if key != "name"}
            if not isinstance(what.get("name"), str):
                raise ConfigurationError(f"a setting as JSON needs a name, got {dict(what)}")
            return self._made(what["name"], own)
        if what not in KNOWN:
            problem = f"there is no setting {what}"
            raise ConfigurationError(
                f"{unknown_name(problem, what, KNOWN)}; or JSON, such as "
                """'{"name": "far", "perception": "blind"}'"""
            )
        return self._made(what, self._arguments(what))

    def _arguments(self, name: str) -> dict[str, Any]:
        """The arguments of a known setting that other settings do not share."""
        if name in (TRUTH, BLIND, LIDAR, STEREO):
            return {"perception": name}
        if name == ERROR_MODEL:
            return _believing(self._needed("error_model", name)[0])
        arguments = {"perception": "sensors", **(self.sensing or {})}
        if self.detector is not None:
            arguments["detector"] = self.detector
        if name == ATTACKED:
            arguments["attack"] = self._needed("attack", name)
        if name == DEFENDED:
            arguments["validator"] = self._needed("validator", name)
            arguments |= self.defended or {}
            if self.attack is not None:
                arguments["attack"] = self.attack
        return arguments

    def _needed(self, part: str, setting: str) -> Any:
        value = getattr(self, part)
        if value in (None, ()):
            raise ConfigurationError(
                f"the setting {setting} needs --{part.replace('_', '-')}: name one"
            )
        return value


_SETTING_WITH = {
    "detector": DETECTOR,
    "attack": ATTACKED,
    "validator": DEFENDED,
    "response": DEFENDED,
    "handover": DEFENDED,
    "classifier": DETECTOR,
    "selector": DETECTOR,
    "error_model": ERROR_MODEL,
}


def _believing(model: str) -> dict[str, Any]:
    return {"perception": {"name": ERROR_MODEL.replace("-", "_"), "model": model}}
