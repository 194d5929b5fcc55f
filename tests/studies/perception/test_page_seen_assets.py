"""What networks have seen: of the frames that they are judged on, and of their assets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from avsec_gym.experiments.json_rows import row_of
from avsec_gym.storage.json_files import read_json
from studies.perception.kept_detections import CarsToFind, LabelledData
from studies.perception.page_frames import held_out
from studies.perception.page_seen_assets import FIRST_EDITION, seen_assets
from studies.perception.training_history import SeenFrames, Training, TrainingHistory

STORED = Path(__file__).parents[3] / "studies/results/training_history.json"
FIRST = SeenFrames("mixed", 1, None, FIRST_EDITION, 10)
TRAIN, JUDGE, ALL = (
    SeenFrames("mixed", seed, assets, "f", 10)
    for seed, assets in ((2, "train"), (3, "judge"), (4, "all"))
)
DATA = LabelledData("mixed", 9, "judge", "f", 4, 4, CarsToFind(4, 4, 4, 4))


def leg(network: str, images: int, *learned: SeenFrames) -> Training:
    return Training(network, "day 1", "a", images, 1.0, None, None, None, None, {}, learned, (), ())


def told(*legs: Training) -> str:
    return "\n".join(seen_assets(legs))


def test_images_count_by_the_assets_of_their_frames() -> None:
    text = told(
        leg("new", 5, TRAIN),
        leg("begun", 7, FIRST),
        leg("begun", 2, TRAIN),
        leg("begun", 1),
        leg("old", 3, FIRST),
    )
    assert "| network | images | first edition | not recorded | training assets |" in text
    assert "| `begun` | 10 | 7 | 1 | 2 |" in text
    assert "`new` learned from training assets alone" in text
    assert "`begun` began on the first edition and went on with training assets" in text
    assert "`old` learned from the first edition alone" in text
    assert "**" not in text


@pytest.mark.parametrize("judged", [[JUDGE], [ALL], [TRAIN, JUDGE]])
def test_a_network_that_learned_from_judging_assets_is_named(judged: Sequence[SeenFrames]) -> None:
    text = told(leg("spoilt", 5, *judged))
    assert "`spoilt` **learned from judging assets, cars among them**" in text


def test_frames_of_an_unknown_world_are_not_taken_for_training_assets() -> None:
    text = told(leg("unknown", 5, replace(FIRST, fingerprint="another")))
    assert "| network | images | not recorded |" in text


def test_any_training_may_have_had_the_judged_layouts() -> None:
    legs = [leg("a", 1, FIRST), leg("a", 1), leg("other", 1, replace(TRAIN, seed=9))]
    assert held_out(DATA, {"a": None}, legs) == (
        "The networks were trained, validated and calibrated on others"
        " (suite `mixed`, seed 1; of 1 training no card records the frames)."
    )
    before = replace(legs[0], calibrated=[replace(TRAIN, seed=9)])
    assert held_out(DATA, {"a": None}, [before, *legs]).startswith("**Not held out")
    assert held_out(DATA, {"b": None}, legs).startswith("No card states")


def test_no_kept_training_had_judging_assets() -> None:
    kept = row_of(TrainingHistory, read_json(STORED, remedy=""))
    text = "\n".join(seen_assets(kept.trainings))
    assert "learned from judging assets" not in text
    assert "`stereo_rcnn`" in text.partition("began on the first edition")[0]
