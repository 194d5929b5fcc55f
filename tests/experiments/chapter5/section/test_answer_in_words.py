"""The answer follows the figures, in every direction."""

from __future__ import annotations

from typing import Any

import pytest

from avsec_gym.experiments.chapter5.section.answer_in_words import answer


def losses(rho: float | None, interval: Any, discordant: int, **changed: Any) -> dict[str, Any]:
    attack = {
        "detector": "dsgn", "attack": "thesis_pgd-1", "strength": 4.0, "whole_levels": False,
        "counts": True, "precision_lost": 40.0, "precision_lost_interval": [30, 45],
        "safety_lost": 0.5, "safety_lost_interval": [-1, 2], **changed,
    }  # fmt: skip
    correlation = {"attacks": 12, "rho": rho, "interval": interval}
    return {
        "scenarios": 600,
        "unattacked": [{"detector": "dsgn", "precision": 45.0, "safety": 90.0}],
        "attacks": [attack],
        "rank_correlation": {"dsgn": correlation, "both": correlation},
        "discordant_pairs": {"dsgn": {"pairs": 66, "concordant": 3, "discordant": discordant}},
    }


@pytest.mark.parametrize(
    ("rho", "interval", "discordant", "kind", "word"),
    [
        (0.9, [0.6, 1.0], 0, "coupled", "Yes."),
        (0.6, [0.2, 0.8], 5, "partly", "Only in part."),
        (0.1, [-0.4, 0.5], 5, "decoupled", "No."),
        (0.1, [-0.1, 0.2], 0, "decoupled", "No."),
        (-0.6, [-0.8, -0.2], 5, "reversed", "No, rather the reverse."),
        (0.3, [-0.4, 0.8], 0, "cannot tell", "This run cannot tell."),
        (None, None, 0, "alike", "This run cannot tell."),
    ],
)
def test_the_answer_follows_the_figures(
    rho: float | None, interval: Any, discordant: int, kind: str, word: str
) -> None:
    found = answer(losses(rho, interval, discordant))
    assert (found["kind"], found["word"]) == (kind, word)


def test_two_attacks_have_no_ranks_to_compare() -> None:
    few = losses(None, None, 0)
    few["rank_correlation"]["dsgn"]["attacks"] = 2
    assert answer(few)["word"] == "There is nothing to compare yet."


def test_what_cannot_be_told_from_nothing_is_not_called_a_loss() -> None:
    (one,) = answer(losses(0.9, [0.6, 1], 0))["detectors"]
    assert one["took"] == [
        "thesis PGD α 1, n 4 took 40.0 of 45.0 points of average precision and did not measurably"
        " change 90.0 points of safe driving (−0.5 [−2.0, +1.0])."
    ]
    gained = losses(0.9, [0.6, 1], 0, safety_lost=-3.0, safety_lost_interval=[-5, -1])
    assert "added 3.0 to 90.0 points" in answer(gained)["detectors"][0]["took"][0]


def test_a_dozen_scenes_give_no_answer() -> None:
    found = answer(losses(0.9, [0.9, 0.9], 0) | {"scenarios": 12})
    assert (found["kind"], found["word"]) == ("few", "This run cannot tell.")
    assert found["sentence"].startswith("12 scenarios are too few")


def test_detectors_may_differ() -> None:
    both = losses(0.9, [0.6, 1], 0)
    both["unattacked"].append({"detector": "stereo_rcnn", "precision": 40.0, "safety": 90.0})
    both["rank_correlation"]["stereo_rcnn"] = {"attacks": 12, "rho": -0.5, "interval": [-0.8, -0.1]}
    both["discordant_pairs"]["stereo_rcnn"] = both["discordant_pairs"]["dsgn"]
    found = answer(both)
    assert found["kind"] == "depends"
    assert found["sentence"].startswith("For DSGN, attacks that take more precision take more")
    assert "for Stereo R-CNN, attacks that take more precision take less" in found["sentence"]
