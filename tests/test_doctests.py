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


@pytest.mark.parametrize("name", MODULES)
def test_examples_of_module(name: str) -> None:
    """Every example gives what it says; modules of absent extras are skipped."""
    try:
        module = importlib.import_module(name)
    except ModuleNotFoundError as error:
        if (error.name or "").startswith(("avsec_gym", "studies")):
            raise
        pytest.skip(f"{error.name} is not installed")
    assert doctest.testmod(module).failed == 0
