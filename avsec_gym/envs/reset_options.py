"""What users may pick when they reset an environment."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avsec_gym.argument_checks import shown
from avsec_gym.errors import ConfigurationError
from avsec_gym.suggestions import unknown_name

OPTIONS = ("scenario", "intention")
"""Options of every environment."""


def reset_options(options: Any, *more: str) -> dict[str, Any]:
    """The options of a reset, a copy.

    Args:
        options: What the user gave: a dictionary, or None.
        more: Names that this environment knows beside `OPTIONS`.

    Raises:
        ConfigurationError: The options are no dictionary, or one has an unknown name.

    Example:
        >>> reset_options({"intention": "left"})
        {'intention': 'left'}
    """
    if options is None:
        return {}
    known = (*OPTIONS, *more)
    if not isinstance(options, Mapping):
        raise ConfigurationError(
            f"the options of reset are a dictionary, such as {{'intention': 'left'}}, got "
            f"{shown(options)}"
        )
    for name in options:
        if name not in known:
            problem = f"reset knows the options {' and '.join(known)}, got {shown(name)}"
            raise ConfigurationError(unknown_name(problem, str(name), known))
    return dict(options)
