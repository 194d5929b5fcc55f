"""The history of weights and scorings, from versions of cards and results."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import pytest

from avsec_gym.experiments.json_rows import as_json, row_of
from avsec_gym.storage.json_files import read_json
from studies.perception import training_history
from studies.perception.page_frames import frames_in_words
from studies.perception.page_history import (
    every_disparity,
    every_scoring,
    real_then_and_now,
    trainings,
)
from studies.perception.training_history import (
    KeptFile,
    RealScoring,
    TrainingHistory,
    disparity_scorings,
    real_of_one_sensor,
    real_of_stereo,
    run,
    scorings,
    trainings_of,
)
from studies.study import ROOT

SOURCE = {"frames": 7, "settings": {"suite": "mixed", "seed": 3}}


def card(sha256: str, steps: int, **more: Any) -> dict[str, Any]:
    return {
        "sha256": sha256,
        "steps": steps,
        "minutes": 2.0,
        "command": f"avsec train dsgn --batch 8 --epochs {steps}",
        "metrics": {"Car_3d_ap11": 10.0 * steps, "Car_3d_ap40": 0.0},
        "data": {"training": [SOURCE]},
        "hardware": "a machine",
        **more,
    }


def test_trainings_are_those_of_the_last_card_with_what_earlier_ones_state() -> None:
    first, lost = card("a", 1), {"sha256": "b", "steps": 5, "command": "avsec train dsgn"}
    last = card("c", 2, samples_seen=99, images_per_hour=11.0, before=[first, lost])
    # A card of the same weights is written again, with another precision.
    again = {**last, "metrics": {"Car_3d_ap11": 44.0}}
    rows = trainings_of(
        "dsgn", [KeptFile("day 1", first), KeptFile("day 3", last), KeptFile("day 4", again)]
    )
    assert [(row.date, row.images, row.hardware) for row in rows] == [
        ("day 1", 8, "a machine"),
        (None, 20, None),
        ("day 3", 99, "a machine"),
    ]
    assert [dict(row.metric) for row in rows] == [
        {"Car_3d_ap11": 10.0},
        {},
        {"Car_3d_ap11": 44.0},
    ]
    assert frames_in_words(rows[0].learned) == "7 frames of `mixed`, seed 3"
    assert trainings_of("dsgn", []) == []
    text = "\n".join(trainings(TrainingHistory(rows, [], [])))
    assert (
        "| `dsgn` | day 3 | 7 frames of `mixed`, seed 3 | 99 | 127 | a machine | 2 | 11 |" in text
    )
    assert "In all 0.1 hours on a machine" in text


def result(seed: int, sha256: str, value: float) -> dict[str, Any]:
    of_iou = {"3d": {"ap11": [0.0, value, 0.0], "ap11_interval": [[0, 0], [1.0, 2.0], [0, 0]]}}
    return {
        "data": {"seed": seed, "fingerprint": str(seed), "frames": 4, "assets": "judge"},
        "detectors": {
            "dsgn": {
                "weights": {"sha256": sha256},
                "average_precision": {"0.7": of_iou, "0.5": of_iou},
            }
        },
    }


def test_each_scoring_counts_once() -> None:
    versions = [
        KeptFile("1", result(5, "aaaaaaaaaa", 3.0)),
        KeptFile("2", result(5, "aaaaaaaaaa", 3.0)),
        KeptFile("3", result(5, "b", 4.0)),
        KeptFile("4", result(6, "b", 7.0)),
        KeptFile("5", result(6, "b", 7.01)),
        KeptFile("6", result(6, "b", 7.2)),
    ]
    rows = list(scorings(iter(versions)))
    # The same frames once more by changed code, where the figure differs as it is printed.
    assert [(row.date, row.seed, row.iou70) for row in rows] == [
        ("1", 5, 3),
        ("3", 5, 4),
        ("4", 6, 7),
        ("6", 6, 7.2),
    ]
    text = every_scoring(rows)
    assert "| 1 | 5 | judge | 4 | `dsgn` | `aaaaaaaa` | in space | 3.0 (1.0 to 2.0) | 3.0 |" in text


def test_a_detector_is_scored_by_the_view_that_its_sensor_has() -> None:
    found = result(5, "aaaaaaaaaa", 3.0)
    of_space = found["detectors"].pop("dsgn")
    of_image = {
        "weights": {"sha256": "bbbbbbbbbb"},
        "average_precision": {
            iou: {"2d": each["3d"]} for iou, each in of_space["average_precision"].items()
        },
    }
    found["detectors"] = {"pointrcnn": of_space, "yolo": of_image}
    rows = list(scorings(iter([KeptFile("1", found)])))
    assert [(row.network, row.metric) for row in rows] == [("pointrcnn", "3d"), ("yolo", "2d")]
    text = "\n".join(every_scoring(rows))
    assert "| `yolo` | `bbbbbbbb` | in the image | 3.0 (1.0 to 2.0) | 3.0 |" in text


def test_each_scoring_of_disparity_counts_once() -> None:
    def version(sha256: str, size: list[int], more: float | None, **data: Any) -> dict[str, Any]:
        found = {} if more is None else {"more_wrong": more, "more_wrong_interval": [0.0, 0.5]}
        world = {"pairs": 9, "estimators": {"psmnet_small": found, "sgbm": {"more_wrong": 0.0}}}
        sizes = {"psmnet_small": size}
        return {"weights": {"sha256": sha256}, "input_sizes": sizes, "world": world, **data}

    versions = [
        KeptFile("1", version("aaaaaaaaaa", [16, 52], None)),
        KeptFile("2", version("aaaaaaaaaa", [16, 52], 0.02)),
        KeptFile("3", version("aaaaaaaaaa", [16, 52], 0.02)),
        KeptFile("4", version("aaaaaaaaaa", [20, 68], 0.01, seed=7)),
    ]
    rows = list(disparity_scorings(iter(versions)))
    assert [(row.date, row.seed, row.size) for row in rows] == [
        ("2", None, [16, 52]),
        ("4", 7, [20, 68]),
    ]
    text = every_disparity(rows)
    assert "| 4 | 7 | 9 | `small`, 68 x 20 | `aaaaaaaa` | 1.00 (0.00 to 50.00) |" in text


def test_real_frames_are_compared_between_the_first_and_the_present_weights() -> None:
    def real(found: int, frames: Any = 13) -> dict[str, Any]:
        counts = {"frames": frames, "found": found, "missed": 12 - found, "false_alarms": 2}
        return {"detectors": {"yolo": {"weights": {"sha256": str(found)}, "real": counts}}}

    one = list(
        real_of_one_sensor(
            iter(
                [KeptFile("1", real(8)), KeptFile("2", real(8)), KeptFile("3", real(6, ["a"] * 13))]
            )
        )
    )
    assert [(row.date, row.found, row.frames) for row in one] == [("1", 8, 13), ("3", 6, 13)]
    assert "| `yolo` | 13 | 8 of 12 (1) | 2 | 6 of 12 (3) | 2 | fewer |" in real_then_and_now(one)


def test_real_results_are_those_of_the_weights_of_their_time() -> None:
    def stereo(found: int) -> dict[str, Any]:
        counts = {"found": found, "missed": 2, "false_alarms": 0}
        return {"detectors": {"dsgn": {"frames": {"000001": counts, "000002": counts}}}}

    # Both weights are of one day; the later result of "b" differs, that of "a" does not.
    two = list(
        real_of_stereo(
            iter(
                [
                    KeptFile("day 1", stereo(1), 2),
                    KeptFile("day 1", stereo(1), 3),
                    KeptFile("day 1", stereo(2), 5),
                    KeptFile("day 2", stereo(3), 6),
                ]
            ),
            [
                KeptFile("day 1", result(5, "a", 1.0), 1),
                KeptFile("day 1", result(5, "b", 1.0), 4),
            ],
        )
    )
    assert two == [
        RealScoring("day 1", "dsgn", "a", 2, 2, 4, 0),
        RealScoring("day 2", "dsgn", "b", 2, 6, 4, 0),
    ]
    text = real_then_and_now(two)
    assert "| `dsgn` | 2 | 2 of 6 (day 1) | 0 | 6 of 10 (day 2) | 0 | more |" in text
    assert "`dsgn`" not in "\n".join(real_then_and_now(two[1:])), "weights beside themselves"


def test_a_card_names_the_frames_that_its_metric_is_of() -> None:
    other = {"frames": 9, "settings": {"suite": "mixed", "seed": 4, "assets": "train"}}
    data = {"training": [SOURCE], "validation": [SOURCE], "calibration": [other]}
    (row,) = trainings_of("dsgn", [KeptFile("1", card("a", 1, data=data))])
    assert frames_in_words(row.measured_on) == "9 frames of `mixed`, seed 4"
    (row,) = trainings_of("dsgn", [KeptFile("1", card("a", 1, data={"validation": [SOURCE]}))])
    assert frames_in_words(row.measured_on) == "7 frames of `mixed`, seed 3"
    # A classifier holds out scenes of its sources.
    (row,) = trainings_of("motion", [KeptFile("1", card("a", 1, data={"sources": [other]}))])
    assert row.learned == row.measured_on == row.validated
    assert row.learned[0].assets == "train"


def test_slow_trainings_are_explained_by_their_cards() -> None:
    arithmetic = "float32: a step took 2.267 s in float32, 4.598 s in bfloat16"
    slow = card(
        "a", 10, compute_seconds=43.2, arithmetic=arithmetic, images_per_hour=1665.0,
        hardware="x86_64 processor, 1 thread",
    )  # fmt: skip
    rows = trainings_of("stereo_rcnn", [KeptFile("1", slow)])
    text = "\n".join(trainings(TrainingHistory(rows, [], [])))
    assert (
        "`stereo_rcnn` 1 (1,665 images an hour) 4.3 s on the average, and 2.3 s when it was"
        " measured at the start (float32)"
    ) in text


def test_versions_of_a_file_come_from_git(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def git(*words: str) -> None:
        given = ["git", "-c", "user.name=a", "-c", "user.email=a@b", *words]
        subprocess.run(given, cwd=tmp_path, check=True, capture_output=True)

    monkeypatch.setattr(training_history, "ROOT", tmp_path)
    folder = tmp_path / training_history.WEIGHTS
    folder.mkdir(parents=True)
    git("init")
    for number in range(2):
        (folder / "dsgn_small.json").write_text(f'{{"sha256": "{number}", "steps": {number}}}')
        git("add", ".")
        git("commit", "-m", "weights")
    (row,) = run(training_history.argparse.Namespace()).trainings
    assert (row.sha256, row.images) == ("1", 4)


def test_the_kept_history_ends_with_the_weights_in_the_package() -> None:
    kept = row_of(
        TrainingHistory, read_json(ROOT / "studies/results/training_history.json", remedy="")
    )
    assert as_json(kept)
    last = {row.network: row.sha256 for row in kept.trainings}
    assert set(last) == set(training_history.NETWORKS)
    for network, name in training_history.NETWORKS.items():
        card = read_json(ROOT / training_history.WEIGHTS / f"{name}.json", remedy="")
        assert last[network] == card["sha256"], network
