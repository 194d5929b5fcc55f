"""The same rows by actors of Ray; skipped where Ray is not installed."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path
from types import ModuleType

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.experiment import Configuration
from avsec_gym.runs.run import Backend, run_experiments
from avsec_gym.runs.run_folder import RunFolder

SMALL = Configuration(limit=3)
HAS_RAY = importlib.util.find_spec("ray") is not None


@pytest.mark.skipif(HAS_RAY, reason="Ray is here")
def test_without_ray_the_extra_is_named(tiny: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"avsec-gym\[distributed\]"):
        run_experiments([tiny.PRECISION], SMALL, tmp_path / "run", backend=Backend.RAY)


@pytest.mark.slow
@pytest.mark.skipif(not HAS_RAY, reason="the extra `distributed` is not installed")
@pytest.mark.filterwarnings("default")
def test_actors_do_the_same(
    tiny: ModuleType, diary: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent), os.pathsep)
    here, there = tmp_path / "here", tmp_path / "there"
    run_experiments([tiny.PRECISION], SMALL, here, workers=0, threads=1)
    run_experiments([tiny.PRECISION], SMALL, there, workers=2, threads=1, backend=Backend.RAY)
    assert RunFolder.open(there).drives() == RunFolder.open(here).drives()
    experiment = tiny.trouble("fine", "killed", "killed once", "bug")
    report = run_experiments(
        [experiment], SMALL, tmp_path / "trouble", workers=1, threads=1, backend=Backend.RAY
    )
    errors = {cell.arguments["what"]: error for cell, error in report.failures}
    assert errors.keys() == {"killed", "bug"}
    assert errors["killed"].endswith("twice.")
