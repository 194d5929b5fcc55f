"""A part of the pipeline as users type it: a name, or JSON with arguments."""

from __future__ import annotations

import json
from typing import Any

from avsec_gym.errors import ConfigurationError


def named_part(text: str, option: str = "--detector") -> Any:
    """A name, or the dictionary that JSON spells.

    Args:
        text: Such as ``dsgn``, or ``{"name": "dsgn", "weights": "my.safetensors"}``.
        option: Where it was typed, for messages.

    Raises:
        ConfigurationError: It looks like JSON and is not.
    """
    if not text.lstrip().startswith("{"):
        return text
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        raise ConfigurationError(f"{option} is no JSON ({error}): {text}") from None
