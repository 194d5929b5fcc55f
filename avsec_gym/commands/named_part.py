"""A part of the pipeline as users type it: a name, or JSON with arguments."""

from __future__ import annotations

from typing import Any

from avsec_gym.errors import ConfigurationError
from avsec_gym.storage.json_files import parse_json


def named_part(text: str, option: str = "--detector") -> Any:
    """A name, or the dictionary that JSON spells.

    Args:
        text: What was typed, such as ``dsgn``, or ``{"name": "dsgn", "weights":
            "my.safetensors"}``.
        option: Where it was typed, for messages.

    Raises:
        ConfigurationError: It looks like JSON and is not.
    """
    if not text.lstrip().startswith("{"):
        return text
    try:
        return parse_json(text)
    except ValueError as error:
        raise ConfigurationError(f"{option} is no JSON ({error}): {text[:200]}") from None
