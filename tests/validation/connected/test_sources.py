"""Folders with connected vehicles: which layout one has, and what it holds."""

from __future__ import annotations

from pathlib import Path

import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.validation.connected.sources import connected_source
from tests.validation.connected.opv2v.opv2v_sample import write_sample


def test_a_folder_in_the_layout_of_opv2v(tmp_path: Path) -> None:
    folder = write_sample(tmp_path)
    source = connected_source(folder)
    assert (source.root, source.layout) == (Path(folder), "opv2v")
    instants = list(source.read())
    assert tuple(each.id for each in instants) == source.names
    assert len(instants) > 1
    # Measured poses are the default; the true ones are others.
    true = next(connected_source(folder, "true").read())
    assert abs(true.scans[0].pose - instants[0].scans[0].pose).max() > 0.5


def test_only_the_first_instants(tmp_path: Path) -> None:
    source = connected_source(write_sample(tmp_path))
    first = source.first(1)
    assert first.names == source.names[:1]
    assert [each.id for each in first.read()] == list(first.names)
    assert (first.root, first.layout) == (source.root, source.layout)
    assert source.first(None) is source


def test_scans_of_different_vehicles_are_not_registered(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="'measured' or 'true'"):
        connected_source(write_sample(tmp_path), "registration")


def test_what_holds_no_vehicles_is_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no such folder"):
        connected_source(tmp_path / "absent")
    with pytest.raises(DataError, match="no connected vehicles"):
        connected_source(tmp_path)
