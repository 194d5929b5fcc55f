"""The examples in the docstrings of every module of the package, and of the studies."""

from __future__ import annotations

import doctest
import importlib
import pkgutil

import pytest

import avsec_gym
import studies

MODULES = sorted(
    module.name
    for package in (avsec_gym, studies)
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    if not module.name.endswith("__main__")
)


LONG = {
    "avsec_gym.validation.connected.validator",
    "avsec_gym.validation.connected.surfaces.deformed_mesh",
    "avsec_gym.envs.planner_driver",
    "avsec_gym.envs.idm_driver",
}
"""Modules whose examples render, drive or optimise."""


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] if name in LONG else []) for name in MODULES],
)
def test_examples_of_module(name: str) -> None:
    """Every example gives what it says; modules of absent extras are skipped."""
    try:
        module = importlib.import_module(name)
    except ModuleNotFoundError as error:
        if (error.name or "").startswith(("avsec_gym", "studies")):
            raise
        pytest.skip(f"{error.name} is not installed")
    assert doctest.testmod(module).failed == 0


def test_long_ones_are_there() -> None:
    assert set(MODULES) >= LONG
