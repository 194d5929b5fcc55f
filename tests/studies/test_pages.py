"""Committed pages are those of the committed results."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

import pytest

from studies.chapter3.real_frames_page import real_frames_page
from studies.chapter5 import costly_errors
from studies.driving_safety.error_models.page import error_models_page
from studies.driving_safety.page import page as driving_safety_page
from studies.index import without_remark
from studies.perception.page import page as detectors_page
from studies.perception.page import read_results
from studies.study import RESULTS, ROOT


def _errors(found: Mapping[str, Any]) -> str:
    return costly_errors.page(found, "python -m studies.chapter5.costly_errors RUN --markdown FILE")


@pytest.mark.parametrize(
    ("name", "page"),
    [
        ("driving_safety", driving_safety_page),
        ("error_models", error_models_page),
        ("identification_real", real_frames_page),
        ("chapter5_errors", _errors),
    ],
)
def test_the_page_is_that_of_the_result(
    name: str, page: Callable[[Mapping[str, Any]], str]
) -> None:
    folder = ROOT / RESULTS
    result = json.loads((folder / f"{name}.json").read_text())
    assert page(result) == without_remark((folder / f"{name}.md").read_text())


def test_the_page_of_detectors_is_that_of_the_results() -> None:
    folder = ROOT / RESULTS
    page = detectors_page(read_results(folder))
    assert page == without_remark((folder / "detectors.md").read_text())
