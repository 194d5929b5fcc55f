"""With the pyramid and without: the same scenarios, and what a patch takes of either."""

from __future__ import annotations

from types import ModuleType

import pytest

from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.chapter5.pyramid import pyramid_rows

BOTH = ("dsgn", "dsgn_without_pyramid")


def test_what_more_is_taken_without_it(made: ModuleType) -> None:
    """Of twenty scenarios the patch takes one with the pyramid, eleven without."""
    results, scenarios = made.MadeResults(), made.names(20)
    for detector, hurt in zip(BOTH, (1, 11), strict=True):
        results.add(Condition(detector), scenarios)
        results.add(Condition(detector, "patch-random"), scenarios, unsafe=scenarios[:hurt])
    results.add(Condition("stereo_rcnn"), scenarios[:3])
    labels = made.outcomes(results, scenarios).labels
    clean, patched = pyramid_rows(results, labels)
    assert (clean.attack, patched.attack) == ("unattacked", "patch-random")
    assert patched.scenarios == 20
    assert patched.figures["safety_taken_with"].value == pytest.approx(5)
    assert patched.figures["safety_taken_without"].value == pytest.approx(55)
    assert patched.figures["safety_difference"].value == pytest.approx(50)
    low, high = patched.figures["safety_difference"].interval
    assert 20 < low < 50 < high < 80
    assert patched.figures["precision_difference"].value == 0
    assert clean.figures["safety_without"].value == 100


def test_it_is_no_detector_of_the_chapters_question(made: ModuleType) -> None:
    results, scenarios = made.MadeResults(), made.names(2)
    for detector in BOTH:
        results.add(Condition(detector), scenarios)
    outcomes = made.outcomes(results, scenarios)
    assert outcomes.conditions == (Condition("dsgn"),)
    assert [row.attack for row in pyramid_rows(results, outcomes.labels)] == ["unattacked"]
    alone = made.MadeResults()
    alone.add(Condition("dsgn"), scenarios)
    assert pyramid_rows(alone, outcomes.labels) == []
