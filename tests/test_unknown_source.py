"""A mistyped name of data is usage; a folder that is not there is missing data."""

from __future__ import annotations

import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.unknown_source import unknown_source

KNOWN = ("procedural", "street", "highway", "mixed")


@pytest.mark.parametrize(
    ("name", "meant"),
    [("procedurl", "procedural"), ("Mixed", "mixed"), ("stret", "street"), ("highways", "highway")],
)
def test_a_name_that_reads_like_one_was_mistyped(name: str, meant: str) -> None:
    error = unknown_source(name, KNOWN, "Name a folder.")
    assert isinstance(error, ConfigurationError)
    assert str(error) == f'there is no data "{name}". Did you mean "{meant}"? Name a folder.'


@pytest.mark.parametrize("name", ["twins", "/data/mixd", "./stret", "mixd/", "KITTI"])
def test_anything_else_is_a_place_that_is_not_there(name: str) -> None:
    error = unknown_source(name, KNOWN, "Name a folder.")
    assert isinstance(error, DataError)
    assert error.path == name
    assert str(error) == f"{name}: There is no such file or folder. Name a folder."
