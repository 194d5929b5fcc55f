"""What `real_frames` found, as a page.

Run ``python -m studies.chapter3.real_frames_page RESULT.json --out PAGE.md``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from avsec_gym.errors import DataError
from avsec_gym.experiments.chapter3.objects.thesis_of_detectors import TAKEN_FOR_AN_OBSTACLE
from avsec_gym.report.markdown_table import UNKNOWN, markdown_table, number
from avsec_gym.storage.json_files import read_json
from avsec_gym.storage.text_files import write_text
from studies.answer import exit_code
from studies.chapter3.real_impact import IMAGE_DETECTORS, LIDAR_DETECTORS

_CRITERIA = {"any": "all four shares", "error": "E alone (the thesis’)"}
_SENSORS = {"S0": "LiDAR", "S1": "camera 3", "S2": "camera 2"}
_COMMAND = "python -m studies.chapter3.real_frames --kitti ROOT --json FILE"
_DETECTORS = {
    "pixor": "PIXOR",
    "pointrcnn": "PointRCNN",
    "faster_rcnn": "Faster R-CNN",
    "yolo": "YOLOv3",
}


def real_frames_page(result: Mapping[str, Any]) -> str:
    """Markdown: what is detected, and what detectors are led to see.

    Args:
        result: The result of `studies.chapter3.real_frames.run`.
    """
    rate, draws, fitted = 100 * result["rate"], result["draws"], result["fitted"]
    lines = [
        "# Attacks on real frames of KITTI",
        "",
        f"Made by `{_COMMAND}`, shown by its `real_frames_page`. The thesis’ attacks, {draws} draws"
        " of each on every frame; in brackets: 95 % intervals, of detectors widened by what the"
        " draws on one frame have in common.",
    ]
    for id, found in result["frames"].items():
        lines += ["", f"## {id}: what LiDAR and two cameras detect, r = {rate:g} %", ""]
        rows = [
            [
                " and ".join(_SENSORS[sensor] for sensor in case.split("+")),
                *(_share(shares[criterion]) for criterion in _CRITERIA),
            ]
            for case, shares in found["cases"].items()
        ]
        rows.append(
            ["no attack", *(_alarm(found["false_alarm"][criterion]) for criterion in _CRITERIA)]
        )
        titles = [f"detected by {words}, %" for words in _CRITERIA.values()]
        lines += markdown_table(["attacked", *titles], rows)
    lines += [
        "",
        f"Thresholds come from {fitted['frames']} frames of the procedural suite"
        f" `{fitted['suite']}`, of KITTI’s own rig, since too few real frames are at hand: with"
        " fewer than 1 / r frames they are the largest clean values. A bogus return behind what"
        " the cameras see as a surface, or where they see none, is missed.",
        "",
        "## What detectors are led to see",
        "",
    ]
    rows = []
    for name in LIDAR_DETECTORS:
        if (found := result["impact"][name]) is None:
            continue
        thesis = f" *{number(100 * TAKEN_FOR_AN_OBSTACLE, 1)}*" if name == "pixor" else ""
        taken = _share(found["taken"]) + thesis
        row = [_DETECTORS[name], str(len(found["frames"])), taken, _share(found["already"])]
        cars = (found.get(key) for key in ("car_taken", "car_already"))
        rows.append([*row, *map(_share, cars)])
    titles = ["frames", "a bogus return is an obstacle, %", "one was there without it, %"]
    titles += ["a pasted car is an obstacle, %", "one was there without it, %"]
    lines += [*markdown_table(["scans by", *titles], rows), ""]
    rows = []
    for name in IMAGE_DETECTORS:
        if (found := result["impact"][name]) is None:
            continue
        wrong = (found[key] for key in ("false_alarms", "false_alarms_attacked"))
        shares = (_share(found[key]) for key in ("found", "found_attacked"))
        row = [_DETECTORS[name], str(len(found["frames"])), *shares]
        rows.append([*row, *(number(count, 2) for count in wrong)])
    titles = ["frames", "cars found, %", "under a facula, %"]
    titles += ["false alarms an image", "under a facula"]
    lines += markdown_table(["images by", *titles], rows)
    lines += [
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


def _share(share: Mapping[str, Any] | None) -> str:
    if share is None or share["rate"] is None:
        return UNKNOWN
    low, high = (number(100 * bound, 1) for bound in share["interval"])
    return f"{number(100 * share['rate'], 1)} [{low}, {high}]"


def _alarm(raised: bool) -> str:
    return "a false alarm" if raised else "no alarm"


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("result", type=Path, help="of real_frames, as JSON")
    parser.add_argument("--out", type=Path, required=True, help="the page")
    options = parser.parse_args(arguments)

    def work() -> None:
        try:
            page = real_frames_page(read_json(options.result, remedy=_COMMAND))
        except (ValueError, KeyError, TypeError) as error:
            raise DataError(
                "This is no result of real_frames.", path=options.result, remedy=_COMMAND
            ) from error
        write_text(options.out, page, overwrite=True)

    return exit_code(work)


if __name__ == "__main__":
    sys.exit(main())
