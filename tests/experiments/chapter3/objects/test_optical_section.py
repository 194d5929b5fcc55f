"""Detectors under optical attacks, from rows to page, with outcomes that are known."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.objects import attack_sizes, sensor_detections
from avsec_gym.experiments.chapter3.objects.attack_sizes import CAMERA, SIZES, size_setting
from avsec_gym.experiments.chapter3.objects.believed_points import CARS
from avsec_gym.experiments.chapter3.objects.believed_rates import BelievedRow, BelievedSummary
from avsec_gym.experiments.chapter3.objects.in_words import optical_sentences
from avsec_gym.experiments.chapter3.objects.score_thresholds import ScoreThreshold
from avsec_gym.experiments.chapter3.objects.section import optical_section
from avsec_gym.experiments.chapter3.objects.sensor_detections import (
    WIDTH,
    reach_name,
    seen_setting,
    truth_setting,
    view_setting,
)
from avsec_gym.experiments.chapter3.objects.tables import BELIEVED_IN_WORDS, OpticalSummaries
from avsec_gym.experiments.chapter3.recordings import SYSTEM
from avsec_gym.experiments.json_rows import row_of
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.report.html import html_page
from avsec_gym.report.run_markdown import markdown_page
from avsec_gym.report.run_report import RunReport, run_report
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    DetectionRow,
    Experiment,
    Measurement,
)
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.evidence.disparity_error import MEASURES

FRAMES = 24
FOUND_OF_SIZE = {LIDAR: 1.5, CAMERA: 150.0}
"""Above it the detector misses the second car of a frame."""


def two_cars() -> Boxes3D:
    return Boxes3D(
        [[-3.0, 1.65, 15.0], [2.0, 1.65, 20.0]], np.tile([1.5, 1.6, 4.0], (2, 1)),
        [-1.57, -1.57], np.ones(2), ["Car", "Car"],
        box2d=[[400.0, 150, 520, 250], [650, 160, 720, 220]],
        truncation=np.zeros(2), occlusion=np.zeros(2), alpha=np.zeros(2),
    )  # fmt: skip


BOGUS = Boxes3D(
    [[0.0, 1.65, 8.0]], [[1.5, 1.6, 4.0]], [-1.57], [0.85], ["Car"],
    box2d=[[560.0, 150, 640, 260]], alpha=np.zeros(1),
)  # fmt: skip


def found(count: int) -> Boxes3D:
    cars = replace(two_cars(), truncation=None, occlusion=None, score=[0.9, 0.8])
    return Boxes3D.concatenate([cars, BOGUS])[:count]


def objects_of(part: str, number: int) -> CellResult:
    """Every third attack hides the second car from a camera, and shows the LiDAR a third one.

    The LiDAR alone sees a bogus one in all but one frame; and in every other frame a box of
    camera 2 is too high to be the others' at an IoU of 0.7.
    """
    id, hidden = f"drive_{number:03d}/0", number % 3 == 0
    views = {WIDTH: 1242.0, **{reach_name(pair): 60.0 for pair in SYSTEM.pairs() if pair[0]}}
    rows = [Measurement(view_setting(part), id, name, value) for name, value in views.items()]
    boxes = {truth_setting(part): two_cars()}
    for sensor in SYSTEM.sensors:
        for camera in SYSTEM.cameras if sensor == LIDAR else (int(sensor),):
            boxes[seen_setting(part, sensor, False, camera)] = found(2)
            seen = found(3 if sensor == LIDAR else 1) if hidden else found(2)
            boxes[seen_setting(part, sensor, True, camera)] = seen
    if part == "fitted":
        boxes = {name: found for name, found in boxes.items() if "attacked" not in name}
    else:
        patch = replace(two_cars()[1:], dimensions=[[1.5, 0.1, 2.5]], rotation_y=[0.0])
        if number != 5:
            patch = replace(patch, location=BOGUS.location)
        boxes[sensor_detections.PATCH] = patch
        if number == 7:
            boxes[seen_setting(part, LIDAR, True, 2)] = found(2)
        elif not hidden:
            # Somewhere that no camera looks.
            bogus = replace(BOGUS, box2d=np.array([[10.0, 10, 50, 20]]))
            both = Boxes3D.concatenate([found(2), bogus])
            boxes[seen_setting(part, LIDAR, True, 2)] = both
        if number % 2:
            high = found(2)
            assert high.box2d is not None
            taller = high.box2d.copy()
            taller[0, 3] += 60.0
            boxes[seen_setting(part, 2, False, 2)] = replace(high, box2d=taller)
    return CellResult((), [DetectionRow(name, id, found) for name, found in boxes.items()], rows)


def sizes_of(part: str, number: int) -> CellResult:
    """The larger an attack the more of it is detected, by all shares sooner than by E."""
    id, random = f"drive_{number:03d}/0", np.random.default_rng([part == "judged", number])
    noise = 0.01 if part == "fitted" else 0.005

    def shares(setting: str, strength: float, error: float, other: float) -> list[Measurement]:
        values = [error, 0.1, other, 0.1]
        return [
            Measurement(setting, id, name, value + random.uniform(0, noise), strength)
            for name, value in zip(MEASURES, values, strict=True)
        ]

    rows = shares(size_setting(part), 0.0, 0.1, 0.1)
    if part == "fitted":
        return CellResult(measurements=rows)
    boxes = [DetectionRow(attack_sizes.TRUTH, id, two_cars())]
    for what, sizes in SIZES.items():
        boxes.append(DetectionRow(size_setting(what), id, found(2), 0.0))
        for place, size in enumerate(sizes, 1):
            share = place / len(sizes)
            rows += shares(
                size_setting(what), size,
                0.1 + 0.1 * (number < 12 * share), 0.1 + 0.1 * (number < 24 * share),
            )  # fmt: skip
            missed = size > FOUND_OF_SIZE[what]
            boxes.append(DetectionRow(size_setting(what), id, found(2 - missed), size))
            if what == CAMERA:
                rows.append(Measurement(size_setting(what), id, attack_sizes.COVERED, 0.2, size))
    return CellResult(detections=boxes, measurements=rows)


def known(work: Any) -> Experiment:
    def cells(configuration: Configuration) -> list[Cell]:
        return [
            Cell.of(f"{__name__}:{work.__name__}_work", "", part=part, number=number)
            for part in ("fitted", "judged")
            for number in range(configuration.limit or FRAMES)
        ]

    return Experiment(work.__name__, "What does light do?", "Chapter 3", cells)


def objects_of_work(configuration: Configuration) -> Any:
    return objects_of


def sizes_of_work(configuration: Configuration) -> Any:
    return sizes_of


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> RunReport:
    root = tmp_path_factory.mktemp("run") / "run"
    experiments = [known(objects_of), known(sizes_of)]
    run_experiments(experiments, Configuration("made_up"), root, workers=0, threads=1)
    report = run_report(RunFolder.open(root))
    json.dumps(report.data, allow_nan=False)
    return report


def shown(report: RunReport, summaries: OpticalSummaries) -> RunReport:
    """The report with a section of other figures."""
    return RunReport(report.facts, [Findings([optical_section(summaries)])])


def test_mismatches_raise_alarms(report: RunReport) -> None:
    rows = {
        (row["scenario"], row["iou"], row["rate"]): row for row in report.data["baseline"]["rows"]
    }
    for scenario in ("LiDAR and two cameras", "three cameras"):
        loose, strict = rows[scenario, 0.5, 0.01], rows[scenario, 0.7, 0.01]
        # All three cameras together miss the same car.
        detected = 6 / 7 if scenario == "three cameras" else 1.0
        assert loose["average"] == pytest.approx(detected / 3)
        assert loose["false_alarms"]["rate"] == 0.0
        assert strict["false_alarms"]["rate"] == 0.5
    assert report.data["baseline"]["frames"] == {"fitted": FRAMES, "judged": FRAMES}


def test_the_impact_has_its_control(report: RunReport) -> None:
    lidar, camera = report.data["impact"]["lidar"], report.data["impact"]["camera"]
    # Both cars of every fitted frame are found from the lower one's score on.
    assert lidar["score"] == 0.8
    taken = {row["score"]: row["taken"]["count"] for row in lidar["by_score"]}
    # The bogus car's score is 0.85, that of the car where one patch stands 0.8.
    assert (taken[0.05], taken[0.8], taken[0.9]) == (FRAMES - 1, FRAMES - 1, 0)
    assert {name: lidar[name]["count"] for name in ("taken", "clean", "newly")} == {
        "taken": FRAMES - 1, "clean": 1, "newly": FRAMES - 2,
    }  # fmt: skip
    clean, lit = camera["clean"]["moderate"], camera["attacked"]["moderate"]
    assert clean["value"] == pytest.approx(100)
    assert clean["lost"] == 0
    # Two thirds of the second cars are found: recall 5/6, that is 9 of 11 points.
    assert lit["value"] == pytest.approx(100 * 9 / 11)
    assert lit["lost"] == pytest.approx(100 * 2 / 11)
    assert 0 < lit["lost_interval"][0] < lit["lost"] < lit["lost_interval"][1]


def test_sensitivity_counts_what_is_beyond_the_threshold(report: RunReport) -> None:
    for what, sizes in SIZES.items():
        rows = report.data["sensitivity"][what]["sizes"]
        assert [row["size"] for row in rows] == [0.0, *sizes]
        for place, row in enumerate(rows[1:], 1):
            detected = place / len(sizes)
            assert row["detected"]["error"]["rate"] == pytest.approx(detected / 2, abs=0.09)
            assert row["detected"]["any"]["rate"] == pytest.approx(detected, abs=0.09)
            missed = row["size"] > FOUND_OF_SIZE[what]
            # One car of two: recall 0.5, six of 11 points.
            lost = 100 * 5 / 11 if missed else 0.0
            assert row["precision"]["moderate"]["lost"] == pytest.approx(lost)
    shares = [100 * row["covered"] for row in report.data["sensitivity"][CAMERA]["sizes"]]
    # The thesis' figures.
    assert shares == pytest.approx([0, 0.95, 3.79, 8.54, 15.18, 23.71, 34.15], abs=0.006)
    assert report.data["sensitivity"][CAMERA]["sizes"][2]["changed"] == pytest.approx(0.2)


def test_page_and_text_show_all_of_it(report: RunReport) -> None:
    said = report.sentences
    taken = "PIXOR takes the bogus return for an obstacle in 23 of 24 frames; without the attack"
    assert f"{taken} it has one there in 1." in said
    page, text = html_page(report), markdown_page(report)
    for words in ("65.32", "63.39", "98.60", "84.62", "61.53", "54.12", "YOLOv3", "PointRCNN"):
        assert words in page
        assert words in text
    for words in ("Figures 3.11 and 3.12", 'id="optical"', "detected by E alone"):
        assert words in page
    assert said[0] in text


def test_without_detectors_the_page_shows_what_is_detected(report: RunReport) -> None:
    sizes = json.loads(json.dumps(report.data["sensitivity"]))
    for what in SIZES:
        sizes[what]["detector"] = ""
        for row in sizes[what]["sizes"]:
            row["precision"] = None
    alone = row_of(OpticalSummaries, {"sensitivity": sizes})
    page = html_page(shown(report, alone))
    assert page.count("AP was not measured.") == 2
    assert "of the frames." in optical_sentences(alone)[0]


def test_too_few_frames_are_not_summed_up(tmp_path: Path) -> None:
    experiments = [known(objects_of), known(sizes_of)]
    configuration = Configuration("made_up", limit=3)
    run_experiments(experiments, configuration, tmp_path / "few", workers=0, threads=1)
    report = run_report(RunFolder.open(tmp_path / "few"))
    assert not any(report.data[name] for name in ("baseline", "impact", "sensitivity"))
    assert 'id="optical"' not in html_page(report)


def test_which_bogus_points_are_believed_is_reported(report: RunReport) -> None:
    def share(count: int) -> Share:
        return share_of(np.arange(FRAMES) < count, [str(frame) for frame in range(FRAMES)])

    rows = [
        BelievedRow(
            "pixor",
            kind,
            taken=share(18 if kind in CARS else 3),
            clean=share(1),
            newly=share(17 if kind in CARS else 2),
        )
        for kind in BELIEVED_IN_WORDS
    ]
    objects = {"pixor": ScoreThreshold(0.61, 0.9, 0.8)}
    known = row_of(OpticalSummaries, report.data)
    every = replace(known, believed=BelievedSummary(objects, rows))
    [sentence] = [each for each in optical_sentences(every) if "planes" in each]
    assert "8.33 % of the bogus planes" in sentence
    assert "70.83 % of the scans of cars" in sentence
    planes = BelievedSummary(objects, [row for row in rows if row.kind not in CARS])
    [sentence] = optical_sentences(OpticalSummaries(believed=planes))
    assert "planes" in sentence
    assert "cars" not in sentence
    anew = shown(report, every)
    for page in (html_page(anew), markdown_page(anew)):
        for words in ("as wide as a car", "PIXOR’s from 0.61", "75.00", "98.60"):
            assert words in page
