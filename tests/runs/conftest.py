"""The tiny experiments, importable here and in worker processes."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest


@pytest.fixture
def tiny(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> ModuleType:
    monkeypatch.syspath_prepend(Path(__file__).parent)
    monkeypatch.setenv("TINY_DIARY", str(tmp_path / "diary"))
    import tiny_experiments

    return tiny_experiments


@pytest.fixture
def diary(tiny: ModuleType, tmp_path: Path) -> Path:
    """A line for each cell that was begun: what it was, and the process."""
    path = tmp_path / "diary"
    path.touch()
    return path


@pytest.fixture
def rows() -> Callable[[Path], dict[str, list[tuple[Any, ...]]]]:
    return _rows


def _rows(root: Path) -> dict[str, list[tuple[Any, ...]]]:
    """Every row of every table, without times."""
    columns = {
        "needs": "*", "cells": "cell, work, arguments, status, error", "drives": "*",
        "detections": "*", "measurements": "*", "timings": "cell, part",
    }  # fmt: skip
    database = sqlite3.connect(root / "results.sqlite")
    try:
        return {
            table: sorted(database.execute(f"SELECT {wanted} FROM {table}"), key=repr)
            for table, wanted in columns.items()
        }
    finally:
        database.close()
