"""Average precision: corner cases of the specification, worked out by hand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.kitti import DetectionFolder, KittiObject
from avsec_gym.metrics.average_precision import LOW_IOU, AveragePrecision, average_precision

NOTHING = Boxes3D.empty()
ONE_OF_ELEVEN = 100 / 11


def boxes(*objects: dict[str, Any]) -> Boxes3D:
    """Cars of 4 m beside each other, each 100 x 50 pixels, but for what is given otherwise."""
    parts = []
    for i, given in enumerate(objects):
        place = given.get("place", i)
        top, height = 100.0, given.get("height", 50.0)
        left = 200.0 * place + given.get("right", 0.0)
        parts.append(
            Boxes3D(
                location=[[5.0 * place + given.get("x", 0.0), given.get("y", 1.6), 20.0]],
                dimensions=[[1.5, 1.6, given.get("length", 4.0)]],
                rotation_y=[0.0],
                score=[given.get("score", 1.0)],
                category=[given.get("category", "Car")],
                box2d=[[left, top, left + 100.0, top + height]],
                truncation=[given.get("truncation", 0.0)],
                occlusion=[given.get("occlusion", 0.0)],
                alpha=[given.get("alpha", 0.0)],
            )
        )
    return Boxes3D.concatenate(parts)


def car(result: AveragePrecision, metric: str = "3d", points: int = 11) -> list[float]:
    return [result.value("Car", metric, level, points) for level in ("easy", "moderate", "hard")]


def test_perfect_detections_of_many_cars_are_a_hundred_percent() -> None:
    frames = [boxes({}, {}, {})] * 40
    result = average_precision(frames, frames)
    for metric in ("2d", "bev", "3d", "aos"):
        assert car(result, metric) == pytest.approx([100] * 3)
        assert car(result, metric, 40) == pytest.approx([100] * 3)
    assert result.labels[0].tolist() == [120] * 3
    assert result.value("Pedestrian") == 0.0


def test_a_single_hit_is_worth_a_point_of_eleven_but_none_of_forty() -> None:
    truth = [boxes({})] + [boxes({}, {})] * 20
    result = average_precision(truth, [boxes({})] + [NOTHING] * 20)
    assert car(result) == pytest.approx([ONE_OF_ELEVEN] * 3)
    assert car(result, points=40) == [0.0] * 3


def test_a_single_hit_below_a_surer_false_alarm_is_worth_half() -> None:
    found = boxes({"score": 0.5}, {"score": 0.9})
    result = average_precision([boxes({})], [found])
    assert car(result) == pytest.approx([ONE_OF_ELEVEN / 2] * 3)


def test_a_less_sure_false_alarm_costs_nothing_at_the_surer_cut() -> None:
    found = boxes({"score": 0.9}, {"score": 0.5})
    assert car(average_precision([boxes({})], [found])) == pytest.approx([ONE_OF_ELEVEN] * 3)


def test_every_frame_counts_with_or_without_detections() -> None:
    """Recall 1/2 is reached where half of the frames are empty-handed: slots 0 to 20 of 40."""
    truth = [boxes({})] * 80
    result = average_precision(truth, [boxes({})] * 40 + [NOTHING] * 40)
    assert car(result) == pytest.approx([100 * 6 / 11] * 3)
    assert car(result, points=40) == pytest.approx([50] * 3)


@pytest.mark.parametrize("frames", [[NOTHING], [NOTHING, NOTHING, NOTHING]])
def test_without_labels_there_is_nothing_to_win(frames: list[Boxes3D]) -> None:
    result = average_precision(frames, [boxes({})] * len(frames), resamples=3)
    assert not result.ap11.any()
    assert not result.labels.any()
    assert result.interval is not None
    assert np.isnan(result.interval).all()
    result = average_precision(frames, frames)
    assert not result.ap40.any()


def test_the_overlap_must_be_more_than_the_threshold() -> None:
    """Boxes of length 4 and 2 about one centre have an IoU of exactly one half."""
    exact = {"Car": (0.5, 0.5, 0.5)}
    below = {"Car": (0.4999, 0.4999, 0.4999)}
    truth, found = [boxes({})], [boxes({"length": 2.0})]
    for metric in ("bev", "3d"):
        hit = average_precision(truth, found, classes=["Car"], min_iou=below)
        missed = average_precision(truth, found, classes=["Car"], min_iou=exact)
        assert car(hit, metric) == pytest.approx([ONE_OF_ELEVEN] * 3)
        assert car(missed, metric) == [0.0] * 3


def test_the_low_thresholds_are_those_of_the_second_set() -> None:
    truth, found = [boxes({})], [boxes({"length": 2.5})]  # IoU 0.625 from above
    standard, low = (
        average_precision(truth, found),
        average_precision(truth, found, min_iou=LOW_IOU),
    )
    assert car(standard, "2d") == car(low, "2d") == pytest.approx([ONE_OF_ELEVEN] * 3)
    assert car(standard, "bev") == [0.0] * 3
    assert car(low, "bev") == car(low, "3d") == pytest.approx([ONE_OF_ELEVEN] * 3)


def test_boxes_above_each_other_overlap_from_above_only() -> None:
    result = average_precision([boxes({})], [boxes({"y": 4.0})])
    assert car(result, "bev") == pytest.approx([ONE_OF_ELEVEN] * 3)
    assert car(result, "3d") == [0.0] * 3


@pytest.mark.parametrize(
    ("what", "counted"),
    [
        ({}, [1, 1, 1]),
        ({"height": 40.0}, [0, 1, 1]),
        ({"height": 40.01}, [1, 1, 1]),
        ({"height": 25.0}, [0, 0, 0]),
        ({"height": 25.01}, [0, 1, 1]),
        ({"occlusion": 1.0}, [0, 1, 1]),
        ({"occlusion": 2.0}, [0, 0, 1]),
        ({"occlusion": 3.0}, [0, 0, 0]),
        ({"truncation": 0.15}, [1, 1, 1]),
        ({"truncation": 0.16}, [0, 1, 1]),
        ({"truncation": 0.31}, [0, 0, 1]),
        ({"truncation": 0.51}, [0, 0, 0]),
        ({"category": "Van"}, [0, 0, 0]),
        ({"category": "car"}, [1, 1, 1]),
    ],
)
def test_which_labels_count_at_which_level(what: dict[str, Any], counted: list[int]) -> None:
    assert average_precision([boxes(what)], [NOTHING]).labels[0].tolist() == counted


@pytest.mark.parametrize(
    "ignored",
    [{"category": "Van"}, {"height": 40.0}, {"occlusion": 1.0}, {"truncation": 0.2}],
)
def test_what_finds_an_ignored_label_is_neither_right_nor_wrong(ignored: dict[str, Any]) -> None:
    """A false alarm in its place would halve the precision; it is the surer detection."""
    truth = [boxes({}, ignored)]
    found = [boxes({"score": 0.5}, {"score": 0.9, "height": ignored.get("height", 50.0)})]
    assert car(average_precision(truth, found))[0] == pytest.approx(ONE_OF_ELEVEN)


def test_a_pedestrian_may_be_a_person_sitting_but_a_car_no_truck() -> None:
    truth = [boxes({"category": "Pedestrian"}, {"category": "Person_sitting"})]
    found = [replace(truth[0], category=["Pedestrian"] * 2, score=[0.5, 0.9])]
    assert average_precision(truth, found).value("Pedestrian") == pytest.approx(ONE_OF_ELEVEN)
    truth = [boxes({}, {"category": "Truck"})]
    found = [replace(truth[0], category=["Car"] * 2, score=[0.5, 0.9])]
    assert average_precision(truth, found).value("Car") == pytest.approx(ONE_OF_ELEVEN / 2)


def test_a_dont_care_region_excuses_false_alarms_in_the_image_only() -> None:
    region = {"category": "DontCare", "place": 1}
    truth = [boxes({}, region)]
    inside = [boxes({"score": 0.5}, {"score": 0.9})]
    result = average_precision(truth, inside)
    for metric in ("2d", "aos"):
        assert car(result, metric) == pytest.approx([ONE_OF_ELEVEN] * 3)
    for metric in ("bev", "3d"):
        assert car(result, metric) == pytest.approx([ONE_OF_ELEVEN / 2] * 3)
    # 70 of 100 pixels inside are not more than 0.7 of the detection.
    at_the_edge = [boxes({"score": 0.5}, {"score": 0.9, "right": 30.0})]
    assert car(average_precision(truth, at_the_edge), "2d") == pytest.approx(
        [ONE_OF_ELEVEN / 2] * 3
    )
    nearly = [boxes({"score": 0.5}, {"score": 0.9, "right": 29.0})]
    assert car(average_precision(truth, nearly), "2d") == pytest.approx([ONE_OF_ELEVEN] * 3)


def test_dont_care_regions_are_as_read_from_files() -> None:
    """Their placeholders (sizes -1, place -1000) neither match nor disturb."""
    region = replace(
        boxes({"category": "DontCare"}),
        dimensions=[[-1.0] * 3], location=[[-1000.0] * 3], rotation_y=[-10.0],
        truncation=[-1.0], occlusion=[-1.0], alpha=[-10.0],
    )  # fmt: skip
    truth = [Boxes3D.concatenate([boxes({"place": 1}), region])]
    result = average_precision(truth, [boxes({"place": 1})])
    assert result.labels[0].tolist() == [1, 1, 1]
    assert car(result, "aos") == pytest.approx([ONE_OF_ELEVEN] * 3)


@pytest.mark.parametrize("category", ["Car", "Cyclist"])
def test_a_small_detection_of_any_class_absorbs_a_label(category: str) -> None:
    """Surer than the proper one, it takes the label in the threshold pass: no score, no recall."""
    truth = [boxes({"height": 41.0}), boxes({})]
    small = {"height": 39.0, "score": 0.9, "category": category, "place": 0}
    proper = {"height": 41.0, "score": 0.5, "place": 0}
    second = boxes({"score": 0.1})
    result = average_precision(truth, [boxes(proper), second])
    assert result.precision[0, 2, 0, :3].tolist() == [1.0, 1.0, 0.0]
    result = average_precision(truth, [boxes(small), second])
    assert result.precision[0, 2, 0, :3].tolist() == [1.0, 0.0, 0.0]
    result = average_precision(truth, [boxes(small, proper), second])
    assert result.precision[0, 2, 0, :3].tolist() == [1.0, 0.0, 0.0]


def test_a_small_detection_is_no_false_alarm() -> None:
    found = boxes({"score": 0.5}, {"score": 0.9, "height": 24.0})
    assert car(average_precision([boxes({})], [found])) == pytest.approx([ONE_OF_ELEVEN] * 3)


def test_the_surest_wins_when_cuts_are_chosen_the_closest_when_counting() -> None:
    """The surer, worse detection sets the cut-off 0.9, where it is a hit; the other is below."""
    truth = [boxes({})]
    close, sure = {"place": 0, "score": 0.5}, {"place": 0, "score": 0.9, "x": 0.3, "alpha": 1.0}
    result = average_precision(truth, [boxes(close, sure)])
    assert car(result, "aos") == pytest.approx([ONE_OF_ELEVEN * (1 + np.cos(1.0)) / 2] * 3)
    # A second label, found at 0.1, lowers a cut-off: now the closest is taken, the surer is wrong.
    truth = [boxes({}, {})]
    third = {"place": 1, "score": 0.1}
    result = average_precision(truth, [boxes(close, sure, third)])
    assert result.precision[0, 2, 0, :2].tolist() == pytest.approx([1.0, 2 / 3])
    assert result.precision[0, 3, 0, :2].tolist() == pytest.approx([(1 + np.cos(1)) / 2, 2 / 3])


def test_one_detection_finds_one_label_and_repeats_are_wrong() -> None:
    twice = boxes({"place": 0, "score": 0.9}, {"place": 0, "score": 0.9})
    assert car(average_precision([boxes({})], [twice])) == pytest.approx([ONE_OF_ELEVEN / 2] * 3)


def test_a_false_alarm_close_to_two_labels_is_one() -> None:
    """Surest, it sets the first cut-off; at the second each label prefers its own detection."""
    truth = [boxes({"place": 0}, {"place": 0, "x": 1.5})]
    own = [{"place": 0, "score": 0.9}, {"place": 0, "x": 1.5, "score": 0.8}]
    between = {"place": 0, "x": 0.75, "score": 0.95}  # IoU 3.25 / 4.75 with both
    result = average_precision(truth, [boxes(*own, between)], min_iou=LOW_IOU)
    assert result.precision[0, 2, 0, :3].tolist() == pytest.approx([1.0, 2 / 3, 0.0])


def test_equal_scores_are_above_the_cut_together() -> None:
    truth = [boxes({}), NOTHING]
    result = average_precision(truth, [boxes({"score": 0.5}), boxes({"score": 0.5})])
    assert car(result) == pytest.approx([ONE_OF_ELEVEN / 2] * 3)


def test_a_reversed_heading_costs_all_similarity() -> None:
    result = average_precision([boxes({})], [boxes({"alpha": np.pi})])
    assert car(result, "aos") == pytest.approx([0.0] * 3, abs=1e-12)
    assert car(result, "2d") == pytest.approx([ONE_OF_ELEVEN] * 3)


def test_orientation_is_unknown_where_a_detection_has_no_alpha() -> None:
    for found in (boxes({"alpha": -10.0}), replace(boxes({}), alpha=None)):
        result = average_precision([boxes({})], [found], resamples=5)
        assert np.isnan(car(result, "aos")).all()
        assert car(result, "2d") == pytest.approx([ONE_OF_ELEVEN] * 3)
        report = result.to_json()["Car"]
        assert report["aos"]["ap11"] == [None] * 3
        assert report["aos"]["ap11_interval"] == [[None, None]] * 3
        assert report["2d"]["ap11"] == [round(ONE_OF_ELEVEN, 4)] * 3


def test_orientation_is_unknown_where_a_label_that_is_missed_has_no_alpha() -> None:
    missed = {"place": 2, "alpha": -10.0}
    result = average_precision([boxes({}, missed)], [boxes({})], resamples=5)
    assert np.isnan(car(result, "aos")).all()
    assert not np.isnan(car(result, "2d")).any()


def test_what_cannot_be_scored_is_refused() -> None:
    with pytest.raises(ConfigurationError, match="2D boxes"):
        average_precision([boxes({})], [replace(boxes({}), box2d=None)])
    with pytest.raises(ConfigurationError, match="1 frames"):
        average_precision([boxes({})], [])
    with pytest.raises(ConfigurationError, match="one or more"):
        average_precision([], [])
    with pytest.raises(ConfigurationError, match="Tram"):
        average_precision([NOTHING], [NOTHING], classes=["Tram"])
    with pytest.raises(ConfigurationError, match="'4d' was not measured"):
        average_precision([NOTHING], [NOTHING]).value("Car", "4d")


def noisy(frames: int, seed: int = 0) -> tuple[list[Boxes3D], list[Boxes3D]]:
    random = np.random.default_rng(seed)
    cars = [{"place": place} for place in range(4)]

    def found() -> list[dict[str, Any]]:
        return [car | {"x": random.normal(0, 0.5), "score": random.random()} for car in cars]

    return [boxes(*cars[:3])] * frames, [boxes(*found()) for _ in range(frames)]


def test_precision_never_rises_with_recall_nor_with_the_threshold() -> None:
    truth, found = noisy(60)
    values = []
    for threshold in (0.3, 0.5, 0.7, 0.9):
        result = average_precision(truth, found, classes=["Car"], min_iou={"Car": (threshold,) * 3})
        assert (np.diff(result.precision) <= 0).all()
        values.append(result.value("Car"))
    assert values == sorted(values, reverse=True)
    assert values[0] > values[-1]


def test_only_the_order_of_scores_matters_not_that_of_frames() -> None:
    truth, found = noisy(30)
    same = average_precision(truth, found).precision
    squashed = [replace(boxes, score=np.exp(7 * boxes.score)) for boxes in found]
    assert average_precision(truth, squashed).precision == pytest.approx(same, nan_ok=True)
    turned = average_precision(truth[::-1], found[::-1]).precision
    assert turned == pytest.approx(same, nan_ok=True)


def test_the_interval_is_that_of_frames_drawn_by_hand() -> None:
    """Each resample, scored as a data set of its own, gives what the events give."""
    truth, found = noisy(25)
    fast = average_precision(truth, found, classes=["Car"], resamples=40, seed=3)
    generator = np.random.default_rng(3)
    slow = []
    for row in generator.integers(0, 25, (40, 25)):
        again = average_precision([truth[i] for i in row], [found[i] for i in row], classes=["Car"])
        slow.append((again.ap11[0], again.ap40[0]))
    expected = np.quantile(slow, (0.025, 0.975), axis=0)  # low/high, AP, metric, level
    assert fast.interval is not None
    assert fast.interval[0] == pytest.approx(np.moveaxis(expected, (0, 1), (3, 2)))
    assert (fast.interval[..., 0] < fast.interval[..., 1]).all()
    repeated = average_precision(truth, found, classes=["Car"], resamples=40, seed=3)
    assert (repeated.interval == fast.interval).all()


def test_point_gnn_on_the_labelled_scenarios(shared: Path) -> None:
    """Its paper reports 78.0 for cars in 3D, moderate, AP11, on the whole split."""
    folder = DetectionFolder(shared / "detections" / "point_gnn")
    data = KittiObject(shared / "kitti" / "object")
    found, _ = folder.read()
    truth = [data.labels(id, keep_dont_care=True) for id in found]
    result = average_precision(truth, list(found.values()), classes=["Car"])
    assert car(result) == pytest.approx([87.38, 77.97, 77.10], abs=0.05)
    assert result.value("Car", "3d", "moderate", 40) == pytest.approx(82.13, abs=0.05)
    assert result.value("Car", "bev") == pytest.approx(87.65, abs=0.05)
