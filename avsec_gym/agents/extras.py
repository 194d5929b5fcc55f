"""What the extra `agents` installs, imported where it is used."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from avsec_gym.errors import ConfigurationError


def yaml_module() -> Any:
    """PyYAML, which reads configurations."""
    return _module("yaml", "PyYAML reads the configurations of agents")


def cma_module() -> Any:
    """`cma`, which searches baselines."""
    return _module("cma", "cma searches the baselines of agents")


def contributed(name: str) -> Any:
    """An algorithm of sb3-contrib, by its class name."""
    return getattr(_module("sb3_contrib", f"sb3-contrib has {name}"), name)


def _module(name: str, purpose: str) -> Any:
    try:
        return import_module(name)
    except ImportError as error:
        raise ConfigurationError(f"{purpose}: pip install 'avsec-gym[agents]'") from error
