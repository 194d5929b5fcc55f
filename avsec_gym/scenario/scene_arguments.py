"""How users name scenes: a name, a folder, or a dictionary of arguments, checked before any use."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import Parameter, signature
from pathlib import Path
from typing import Any

from avsec_gym.argument_checks import flag, number, one_of, shown, whole_number
from avsec_gym.errors import ConfigurationError
from avsec_gym.suggestions import unknown_name
from avsec_gym.world.assets import Assets
from avsec_gym.world.layouts import MOST_LAYOUTS


def scene_arguments(what: Any, function: Callable[..., Any]) -> dict[str, Any]:
    """The arguments of a function that makes scenes; hashable, so that the scenes can be kept.

    Args:
        what: The function's first argument, or a dictionary of all that are named.
        function: The function, which takes names, paths, or lists of them; and a ``count``, a
            ``seed``, a number of ``vehicles``, a flag ``contested``, seconds ``every``, and a part
            of the ``assets``.

    Raises:
        ConfigurationError: These are no such arguments.

    Example:
        >>> from avsec_gym.scenario.scene_sets import scene_set
        >>> scene_arguments("layouts", scene_set)
        {'name': 'layouts'}
    """
    parameters = signature(function).parameters
    first = next(iter(parameters))
    given = what if isinstance(what, Mapping) else {first: what}
    for name in given:
        if name not in parameters:
            problem = f"scenarios have no argument {shown(name)}"
            raise ConfigurationError(unknown_name(problem, str(name), parameters))
    if first not in given and parameters[first].default is parameters[first].empty:
        raise ConfigurationError(
            f"scenarios given as a dictionary need a {first!r}, got {shown(what)}"
        )
    return {name: _checked(parameters[name], value) for name, value in given.items()}


def _checked(parameter: Parameter, value: Any) -> Any:
    name = parameter.name
    if value is None and parameter.default is None:
        return None
    if name == "count":
        return whole_number(name, value, 1, MOST_LAYOUTS)
    if name == "vehicles":
        return whole_number(name, value, 1)
    if name == "seed":
        return whole_number(name, value, 0)
    if name == "every":
        return number(name, value, 0.1, 60.0)
    if name == "contested":
        return flag(name, value)
    if name == "assets":
        return one_of("part of the assets", value, Assets)
    if isinstance(value, str | Path):
        return str(value)
    several = "Sequence" in str(parameter.annotation) and isinstance(value, list | tuple)
    if several and value and all(isinstance(each, str | Path) for each in value):
        return tuple(map(str, value))
    raise ConfigurationError(
        f"scenarios are a name, a folder, or a dictionary of arguments; {name} is a name or a "
        f"folder, got {shown(value)}"
    )
