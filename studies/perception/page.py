"""Writes studies/results/detectors.md: every figure of it comes from the JSON files beside it.

Run ``python -m studies.perception.page --results studies/results``, after the commands
that write these files (``python -m studies.detectors``).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from avsec_gym.errors import DataError
from avsec_gym.report.markdown_table import interval, markdown_table, number
from avsec_gym.storage.json_files import read_json
from avsec_gym.storage.regular_files import is_file
from avsec_gym.storage.text_files import write_text
from studies.answer import answer
from studies.perception.page_classifiers import classifiers
from studies.perception.page_errors import examples, metres, reasons
from studies.perception.page_networks import (
    disparity,
    parity,
    ranking,
    real,
    seconds,
    training,
)
from studies.perception.page_single_sensor import single_sensor

FILES = {
    "detectors": "detectors.json",
    "single": "single_sensor_detectors.json",
    "curves": "detector_training.json",
    "real": "real_frames.json",
    "disparity": "disparity.json",
    "classifiers": "classifiers.json",
    "seconds": "detector_benchmark.json",
    "ranking": "detector_ranking.json",
    "parity": "parity.json",
}
"""What the page shows; only the first must be there."""

_ASSETS = {
    "all": "all designs",
    "train": "the designs that networks are trained on",
    "judge": "designs that no network was trained on",
}
_METRICS = {"2d": "in the image", "bev": "from above", "3d": "in space", "aos": "orientation"}
_MODERATE = 1


def run(options: argparse.Namespace) -> dict[str, Any]:
    """Write the page; which files it was made of.

    Raises:
        DataError: There is no result of the detectors, or a file is no JSON.
    """
    results = {}
    for name, file in FILES.items():
        path = options.results / file
        if is_file(path):
            results[name] = read_json(path, remedy="Make it anew.")
    if "detectors" not in results:
        raise DataError(
            "There is no result of the detectors.",
            path=options.results / FILES["detectors"],
            remedy="python -m studies.perception.detector_precision writes it.",
        )
    write_text(options.results / "detectors.md", page(results), overwrite=True)
    return {"page": "detectors.md", "of": [FILES[name] for name in results]}


def page(results: Mapping[str, Any]) -> str:
    """The page as Markdown.

    Args:
        results: The results by the names of `FILES`; parts that are not there are left out.
    """
    scores = results["detectors"]
    sections = [
        _head(scores),
        _bar(scores),
        _in_full(scores),
        _by_distance(scores),
        reasons(scores),
        examples(scores),
    ]
    if "single" in results:
        sections.append(single_sensor(results["single"]))
    parts = (results.get(name) for name in ("single", "disparity", "curves"))
    sections.append(training(scores["detectors"], *parts))
    for name, section in (
        ("real", real),
        ("disparity", disparity),
        ("classifiers", classifiers),
        ("seconds", seconds),
        ("ranking", ranking),
        ("parity", parity),
    ):
        if name in results:
            sections.append(section(results[name]))
    return "\n\n".join("\n".join(section) for section in sections if section) + "\n"


def _head(scores: Mapping[str, Any]) -> list[str]:
    data, cars = scores["data"], scores["data"]["cars"]
    where, made = "labelled frames", []
    if data["suite"] is not None:
        suite, seed, assets = data["suite"], data["seed"], data.get("assets") or "all"
        where = (
            f"frames of the procedural world (suite `{suite}`, seed {seed}, {_ASSETS[assets]},"
            f" sources {data['fingerprint']})"
        )
        made = [
            f"avsec world make --suite {suite} --frames {data['frames']} --seed {seed}"
            f" --assets {assets} --no-lidar --out HELD_OUT"
        ]
    return [
        "# What the small detectors reach",
        "",
        f"On {data['frames']} {where} with {data['objects']} labelled objects, {cars['all']} of"
        f" them cars; to be found are {cars['easy']} (easy), {cars['moderate']} (moderate),"
        f" {cars['hard']} (hard). {_held_out(scores)}"
        " Average precision of cars by KITTI's rules in percent, with 95 % bootstrap intervals over"
        f" frames ({scores['resamples']} draws). Numbers in [detectors.json](detectors.json);"
        " everything on this page is made by `python -m studies.detectors`, this part by",
        "",
        "```",
        *made,
        "python -m studies.perception.detector_precision --kitti HELD_OUT"
        f" --detectors {' '.join(row['asked'] for row in scores['detectors'].values())}",
        "```",
    ]


def _held_out(scores: Mapping[str, Any]) -> str:
    """What the cards of the weights say of these frames."""
    cards = [figures["weights"] for figures in scores["detectors"].values() if figures["weights"]]
    learned = {
        (source["suite"], source["seed"])
        for card in cards
        for sources in card["data"].values()
        for source in sources
    }
    if not learned:
        return "No card states what the detectors learned from."
    if (scores["data"]["suite"], scores["data"]["seed"]) in learned:
        return "**Not held out: a detector was trained or validated on this suite and seed.**"
    known = ", ".join(f"`{suite}` {seed}" for suite, seed in sorted(learned, key=str))
    return f"The networks were trained and validated on others (suite and seed: {known})."


def _bar(scores: Mapping[str, Any]) -> list[str]:
    rows, remarks, reached = [], [], {}
    for name, figures in scores["detectors"].items():
        ap = figures["average_precision"]
        value = reached[name] = ap["0.7"]["3d"]["ap11"][_MODERATE]
        rows.append(
            [
                f"`{name}`",
                _ap(ap["0.7"]["3d"], "ap11"),
                number(figures["bar"], 0),
                _ap(ap["0.7"]["3d"], "ap40"),
                _ap(ap["0.5"]["3d"], "ap11"),
                _ap(ap["0.5"]["3d"], "ap40"),
                number(figures["thesis"] and figures["thesis"][_MODERATE], 2),
            ]
        )
        if figures["bar"] is not None:
            less = figures["bar"] - value
            remarks.append(
                f"`{name}` {'misses' if less > 0 else 'passes'} the bar by {abs(less):.1f}."
            )
    order = sorted(reached, key=lambda name: -reached[name])
    return [
        "## Against the bar",
        "",
        "Cars in space, moderate. The bar is that of AP11 at IoU 0.7, set by the thesis' figures"
        " for the full networks on real KITTI, which stand beside it: other networks, other data.",
        "",
        *markdown_table(
            ["detector", "AP11, IoU 0.7", "bar", "AP40, IoU 0.7", "AP11, IoU 0.5", "AP40, IoU 0.5",
             "thesis, AP11, IoU 0.7"],
            rows,
        ),
        "",
        " ".join([*remarks, "In order of precision: " + ", ".join(order) + "."]),
    ]  # fmt: skip


def _in_full(scores: Mapping[str, Any]) -> list[str]:
    lines = ["## In full", "", "Easy / moderate / hard; the interval is that of moderate."]
    for name, figures in scores["detectors"].items():
        rows = []
        for metric, title in _METRICS.items():
            for iou, values in figures["average_precision"].items():
                if iou == "0.5" and metric not in ("bev", "3d"):
                    continue  # In the image both sets of thresholds ask for 0.7.
                cells = [_levels(values[metric], points) for points in ("ap11", "ap40")]
                rows.append([title, iou, *cells])
        lines += ["", f"**`{name}`**", ""]
        lines += markdown_table(["metric", "IoU", "AP11", "AP40"], rows)
        lines += ["", f"![Precision over recall of {name}](images/{name}_precision.png)"]
    return lines


def _by_distance(scores: Mapping[str, Any]) -> list[str]:
    rows = []
    for name, figures in scores["detectors"].items():
        for part in figures["by_distance"]:
            if "0.7" in part:
                cells = [
                    _ap(part[iou][metric], "ap11", None)
                    for metric in ("3d", "bev")
                    for iou in ("0.7", "0.5")
                ]
                rows.append([f"`{name}`", metres(part), str(part["cars"]), *cells])
    return [
        "## By distance",
        "",
        "AP11 of the cars at a range of distance ahead, moderate. Ranges with too few cars for"
        " KITTI's recall points are left out.",
        "",
        *markdown_table(
            ["detector", "metres", "cars", "in space, 0.7", "in space, 0.5", "from above, 0.7",
             "from above, 0.5"],
            rows,
        ),
    ]  # fmt: skip


def _ap(values: Mapping[str, Any], points: str, level: int | None = _MODERATE) -> str:
    """Of a list over levels, or of one level where `level` is None."""
    value, bounds = values[points], values.get(f"{points}_interval")
    if level is not None:
        value, bounds = value[level], bounds and bounds[level]
    return interval(value, bounds)


def _levels(values: Mapping[str, Any], points: str) -> str:
    bounds = values.get(f"{points}_interval")
    text = " / ".join(number(value, 1) for value in values[points])
    return text + (f" ({bounds[_MODERATE][0]:.1f} to {bounds[_MODERATE][1]:.1f})" if bounds else "")


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--results", type=Path, default=Path("studies/results"))
    parser.add_argument("--json", type=Path, help="file for a summary; default: standard output")
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
