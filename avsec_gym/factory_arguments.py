"""Which arguments a factory takes, asked before it is called."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from inspect import Parameter, signature
from typing import Any

from avsec_gym.errors import ConfigurationError
from avsec_gym.suggestions import unknown_name


def check_arguments(
    what: str, factory: Callable[..., Any], arguments: Iterable[str], where: str = ""
) -> None:
    """Refuse arguments that a factory does not have, before it is called.

    Args:
        what: What it makes, for the message.
        factory: The function or class that makes it from keyword arguments.
        arguments: The names of those that are given.
        where: Where its arguments are described, for the message.

    Raises:
        ConfigurationError: It has no such argument.

    Example:
        >>> check_arguments("a number", complex, ["image"])  # doctest: +ELLIPSIS
        Traceback (most recent call last):
        avsec_gym.errors.ConfigurationError: a number has no argument 'image'. Did you mean...
    """
    parameters = named_parameters(factory)
    if parameters is None:
        return
    known = [each.name for each in parameters]
    for given in arguments:
        if given not in known:
            problem = f"{what} has no argument {given!r}{where}"
            raise ConfigurationError(unknown_name(problem, str(given), known))


def named_parameters(factory: Callable[..., Any]) -> list[Parameter] | None:
    """What may be given by name; None where it cannot be known, or may be anything."""
    try:
        parameters = list(signature(factory).parameters.values())
    except (TypeError, ValueError):  # Not every callable shows its arguments.
        return None
    if any(each.kind == Parameter.VAR_KEYWORD for each in parameters):
        return None
    named = (Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY)
    return [each for each in parameters if each.kind in named]
