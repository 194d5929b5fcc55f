"""What the page states of cards and curves: the frames of a precision, and what curves can show."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from avsec_gym.experiments.json_rows import row_of
from studies.perception.page_training import training
from studies.perception.training_curves import LossPoint, NetworkCurves, ValidationPoint
from studies.perception.training_history import SeenFrames, Training
from studies.perception.weights_facts import WeightsFacts

CARD = row_of(
    WeightsFacts,
    {
        "network": "dsgn",
        "sha256": "a" * 64,
        "storage": "float16",
        "versions": {},
        "metrics": {"Car_3d_ap11": 45.5},
        "trainings": [],
        "bytes": 1000,
        "data": {"training": [], "validation": []},
    },
)
VALIDATED, CALIBRATED = (SeenFrames("mixed", seed, "train", "f", 8) for seed in (901, 101))
LEG = Training(
    "psmnet", "day 1", CARD.sha256, 1, 1.0, None, None, None, None, {}, (), [VALIDATED],
    [CALIBRATED],
)  # fmt: skip


class Disparity:
    """A result of which the card alone is looked at."""

    weights = CARD


def page_of(curves: NetworkCurves, leg: Training = LEG) -> str:
    found: Any = Disparity()
    return "\n".join(training({}, None, found, {"psmnet": curves}, [leg]))


def curves(*validated: int, begins: int) -> NetworkCurves:
    points = [ValidationPoint(step, 1.0, {"Car_3d_ap11": 41.6}) for step in validated]
    return NetworkCurves([LossPoint(20, {"total": 1.0})], points, [begins])


def test_a_precision_has_the_frames_that_it_was_measured_on() -> None:
    text = page_of(curves(5, 20, begins=10))
    row = "| AP11 in space 45.5 | 8 frames of `mixed`, seed 101, calibrated on them | 41.6 |"
    assert row in text
    uncalibrated = page_of(curves(5, 20, begins=10), replace(LEG, calibrated=[]))
    assert "| AP11 in space 45.5 | 8 frames of `mixed`, seed 901 | – |" in uncalibrated
    # A validation of an earlier training, or on the way, is of other weights.
    for earlier in (curves(10, begins=10), curves(15, begins=10)):
        assert "calibrated on them | – |" in page_of(earlier)


def test_few_validations_show_no_rise() -> None:
    few = page_of(curves(5, 20, begins=10))
    assert "of all trainings: `psmnet` 2. Fewer than two of them are of the last" in few
    assert "Fewer than two" not in page_of(curves(15, 20, begins=10))
