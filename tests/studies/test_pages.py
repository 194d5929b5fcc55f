"""Committed pages are those of the committed results, which their rows read and write."""

from __future__ import annotations

import json
from collections.abc import Callable
from types import ModuleType
from typing import Any

import pytest

from avsec_gym.experiments.json_rows import row_json, row_of
from studies.chapter3.other_pairs import OtherPairs
from studies.chapter3.real_frames_page import real_frames_page
from studies.chapter3.real_frames_result import RealFramesResult
from studies.chapter3.shipped_fits.judged_result import JudgedFits
from studies.chapter5 import costly_errors, score_thresholds, telling_page
from studies.chapter5.costly_errors import CostlyErrors
from studies.chapter5.ghost_ceiling import GhostCeilings
from studies.chapter5.ghost_ceiling_page import ceiling_page
from studies.chapter5.patch_signal import PatchSignals
from studies.chapter5.patch_signal_page import signal_page
from studies.chapter5.score_thresholds import SweptThresholds
from studies.chapter5.telling_page import TellingMeasures
from studies.driving_safety.error_models.page import error_models_page
from studies.driving_safety.error_models.result import CheckedModels
from studies.driving_safety.page import page as driving_safety_page
from studies.driving_safety.rows import DrivingSafetyResults
from studies.index import without_remark
from studies.perception.page import page as detectors_page
from studies.perception.page import read_results
from studies.study import RESULTS, ROOT


def _read(name: str, kind: type[Any]) -> Any:
    return row_of(kind, json.loads((ROOT / RESULTS / f"{name}.json").read_text()))


PAGES: dict[str, tuple[type[Any], Callable[[Any], str]]] = {
    "error_models": (CheckedModels, error_models_page),
    "identification_real": (RealFramesResult, real_frames_page),
    "ghost_ceiling": (GhostCeilings, ceiling_page),
    "patch_signal": (PatchSignals, signal_page),
    "chapter5_errors": (
        CostlyErrors,
        lambda found: costly_errors.page(found, _command(costly_errors)),
    ),
    "chapter5_thresholds": (
        SweptThresholds,
        lambda found: score_thresholds.page(found, _command(score_thresholds)),
    ),
    "telling_measures": (
        TellingMeasures,
        lambda found: telling_page.page(found, f"{_command(telling_page)} --figure FILE"),
    ),
}


def _command(module: ModuleType) -> str:
    return f"python -m {module.__name__} RUN --markdown FILE"


@pytest.mark.parametrize("name", PAGES)
def test_the_page_is_that_of_the_result(name: str) -> None:
    kind, page = PAGES[name]
    assert page(_read(name, kind)) == _committed(name)


def test_the_page_of_driving_safety_is_that_of_the_result() -> None:
    result = json.loads((ROOT / RESULTS / "driving_safety.json").read_text())
    assert driving_safety_page(DrivingSafetyResults.of(result)) == _committed("driving_safety")


def test_the_page_of_detectors_is_that_of_the_results() -> None:
    assert detectors_page(read_results(ROOT / RESULTS)) == _committed("detectors")


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("ghost_ceiling", GhostCeilings),
        ("identification_real", RealFramesResult),
        ("other_pairs", OtherPairs),
        ("patch_signal", PatchSignals),
        ("shipped_fits", JudgedFits),
        ("telling_measures", TellingMeasures),
    ],
)
def test_a_result_that_was_read_is_written_as_it_was(name: str, kind: type[Any]) -> None:
    text = json.dumps(row_json(_read(name, kind)), indent=1)
    assert text + "\n" == (ROOT / RESULTS / f"{name}.json").read_text()


def _committed(name: str) -> str:
    return without_remark((ROOT / RESULTS / f"{name}.md").read_text())
