"""What `real_frames` found, as a page.

Run ``python -m studies.chapter3.real_frames_page RESULT.json --out PAGE.md``.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence

from avsec_gym.experiments.chapter3.objects.thesis_of_detectors import TAKEN_FOR_AN_OBSTACLE
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.report.markdown_table import UNKNOWN, markdown_table, number
from studies.chapter3.real_frames_result import (
    DetectionOnFrame,
    ImageImpact,
    RealFramesResult,
    ScanImpact,
)
from studies.page_of_result import page_of_result

_CRITERIA = {"any": "all four shares", "error": "E alone (the thesis’)"}
_SENSORS = {"S0": "LiDAR", "S1": "camera 3", "S2": "camera 2"}
_COMMAND = "python -m studies.chapter3.real_frames --kitti ROOT --json FILE"
_DETECTORS = {
    "pixor": "PIXOR",
    "pointrcnn": "PointRCNN",
    "faster_rcnn": "Faster R-CNN",
    "yolo": "YOLOv3",
}


def real_frames_page(result: RealFramesResult) -> str:
    """Markdown: what is detected, and what detectors are led to see.

    Args:
        result: The result of `studies.chapter3.real_frames.run`.
    """
    impact = result.impact
    lines = [
        "# Attacks on real frames of KITTI",
        "",
        f"Made by `{_COMMAND}`, shown by its `real_frames_page`. The thesis’ attacks,"
        f" {result.draws} draws of each on every frame; in brackets: 95 % intervals, of detectors"
        " widened by what the draws on one frame have in common.",
    ]
    for id, found in result.frames.items():
        title = f"## {id}: what LiDAR and two cameras detect, r = {100 * result.rate:g} %"
        lines += ["", title, "", *_detected(found)]
    lines += [
        "",
        f"Thresholds come from {result.fitted.frames} frames of the procedural suite"
        f" `{result.fitted.suite}`, of KITTI’s own rig, since too few real frames are at hand: with"
        " fewer than 1 / r frames they are the largest clean values. A bogus return behind what"
        " the cameras see as a surface, or where they see none, is missed.",
        "",
        "## What detectors are led to see",
        "",
        *_led_to_see_in_scans({"pixor": impact.pixor, "pointrcnn": impact.pointrcnn}),
        "",
        *_led_to_see_in_images({"faster_rcnn": impact.faster_rcnn, "yolo": impact.yolo}),
        "",
        "Cars: moderate ones, IoU 0.5; pasted: scans of real cars, cut out of other frames, where"
        " the bogus return was, which hide what is behind them; the same few cars on all frames,"
        " which intervals do not know. From which score on a box counts,"
        " is where a detector finds most for its false alarms on frames of that suite; it was"
        " trained on the world and has seen no real frame. *Italics*: the thesis, by PIXOR on a"
        " thousand frames.",
        "",
    ]
    return "\n".join(lines)


def _detected(found: DetectionOnFrame) -> list[str]:
    """A line for each set of attacked sensors, and one for the unattacked frame."""
    rows = [
        [
            " and ".join(_SENSORS[sensor] for sensor in case.split("+")),
            *(_share(shares[criterion]) for criterion in _CRITERIA),
        ]
        for case, shares in found.cases.items()
    ]
    rows.append(["no attack", *(_alarm(found.false_alarm[criterion]) for criterion in _CRITERIA)])
    titles = [f"detected by {words}, %" for words in _CRITERIA.values()]
    return markdown_table(["attacked", *titles], rows)


def _led_to_see_in_scans(impact: Mapping[str, ScanImpact | None]) -> list[str]:
    """A line for each detector of scans."""
    rows = []
    for name, found in impact.items():
        if found is None:
            continue
        thesis = f" *{number(100 * TAKEN_FOR_AN_OBSTACLE, 1)}*" if name == "pixor" else ""
        cars = _share(found.car_taken), _share(found.car_already)
        taken, already = _share(found.taken) + thesis, _share(found.already)
        rows.append([_DETECTORS[name], str(len(found.frames)), taken, already, *cars])
    titles = ["frames", "a bogus return is an obstacle, %", "one was there without it, %"]
    titles += ["a pasted car is an obstacle, %", "one was there without it, %"]
    return markdown_table(["scans by", *titles], rows)


def _led_to_see_in_images(impact: Mapping[str, ImageImpact | None]) -> list[str]:
    """A line for each detector of images."""
    rows = []
    for name, found in impact.items():
        if found is None:
            continue
        shares = _share(found.found), _share(found.found_attacked)
        wrong = number(found.false_alarms, 2), number(found.false_alarms_attacked, 2)
        rows.append([_DETECTORS[name], str(len(found.frames)), *shares, *wrong])
    titles = ["frames", "cars found, %", "under a facula, %"]
    titles += ["false alarms an image", "under a facula"]
    return markdown_table(["images by", *titles], rows)


def _share(share: Share | None) -> str:
    if share is None or share.rate is None or share.interval is None:
        return UNKNOWN
    low, high = (number(100 * bound, 1) for bound in share.interval)
    return f"{number(100 * share.rate, 1)} [{low}, {high}]"


def _alarm(raised: bool) -> str:
    return "a false alarm" if raised else "no alarm"


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    return page_of_result(
        arguments,
        RealFramesResult,
        real_frames_page,
        maker="real_frames",
        what=__doc__,
        remedy=_COMMAND,
    )


if __name__ == "__main__":
    sys.exit(main())
