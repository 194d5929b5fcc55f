"""The figures of `studies/results/world.md`: rendered frames (blue) over real ones (grey)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import contextmanager
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.drawing.figure_style import FAINT, FIGURE_STYLE
from studies.world.scans import ELEVATIONS, RANGES, REFLECTANCES

_OURS, _REAL = "#0072B2", "#BDBDBD"
_MARKS = ["#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#8B4513", "#999900"]
_STYLE: dict[Any, Any] = {
    **FIGURE_STYLE,
    "axes.spines.top": False,
    "axes.spines.right": False,
}
_TITLE: dict[str, Any] = {"loc": "left", "fontsize": 10, "weight": "bold"}


def draw_stereo(
    rows: Sequence[Mapping[str, Any]], real: Mapping[str, Mapping[str, Any]], path: Path
) -> None:
    """How hard pairs are: histograms of rendered ones, real ones as marks.

    Args:
        rows: The rows of `stereo.measure`.
        real: The result of `stereo.real_pairs`.
        path: Where the PNG goes.
    """
    panels = (
        ("wrong", "Wrong of the found disparities (%)", np.linspace(0, 30, 31), "lidar"),
        ("density", "Found of the LiDAR's points (%)", np.linspace(60, 100, 41), "lidar"),
        ("filled", "Found of all pixels (%)", np.linspace(50, 100, 51), "dense"),
    )
    with _figure(path, 1, 3, (14, 3.6)) as axes:
        for (name, title, edges, truth), panel in zip(panels, axes, strict=True):
            values = [100 * row[truth][name] for row in rows if row[truth][name] is not None]
            panel.hist(np.clip(values, edges[0], edges[-1]), edges, color=_OURS, alpha=0.75)
            panel.set_title(title, **_TITLE)
            panel.set_ylabel("rendered pairs")
            there = {key: pair[name] for key, pair in real.items() if pair[name] is not None}
            for colour, (key, value) in zip(cycle(_MARKS), there.items(), strict=False):
                label = f"real: {key.replace('_10', '')}"
                panel.axvline(100 * value, color=colour, linewidth=1.8, label=label)
            panel.legend(frameon=False, fontsize=8)


def draw_scans(scans: Mapping[str, Any], path: Path) -> None:
    """Where a scan's points lie, and how bright they are.

    Args:
        scans: The result of `scans.summary`.
        path: Where the PNG goes.
    """
    panels: tuple[tuple[str, str, Any], ...] = (
        ("range", "Range (m), % of points", RANGES),
        ("elevation", "Elevation (degrees), % of points", ELEVATIONS),
        ("reflectance", "Reflectance, % of points", REFLECTANCES),
        ("beams", "Points of each beam, from the top", np.arange(65.0) - 0.5),
    )
    with _figure(path, 1, 4, (16, 3.4)) as axes:
        for (name, title, edges), panel in zip(panels, axes, strict=True):
            scale = 1.0 if name == "beams" else 100.0
            places = np.arange(len(edges)) if name in ("range", "elevation") else edges
            for source, colour, filled in (("real", _REAL, True), ("scans", _OURS, False)):
                if scans[source]:
                    values = scale * np.array(scans[source][name])
                    panel.stairs(values, places, fill=filled, color=colour, linewidth=1.8)
            if name in ("range", "elevation"):
                panel.set_xticks(places, [f"{edge:g}" for edge in edges], fontsize=7)
            panel.set_title(title, **_TITLE)


def draw_labels(labels: Mapping[str, Any], path: Path) -> None:
    """Histograms of all that is compared, and objects of each category.

    Args:
        labels: The result of `labels.summary`.
        path: Where the PNG goes.
    """
    quantities = {key: each for key, each in labels["quantities"].items() if key != "category"}
    with _figure(path, 3, 4, (15, 9.5)) as axes:
        for panel, quantity in zip(axes, quantities.values(), strict=False):
            for source, colour, filled in (("kitti", _REAL, True), ("ours", _OURS, False)):
                values = 100 * np.array(quantity[source])
                panel.stairs(values, quantity["edges"], fill=filled, color=colour, linewidth=1.8)
            unit = f" ({quantity['unit']})" if quantity["unit"] else ""
            known = [quantity[name] for name in ("distance", "yardstick")]
            note = ", ".join(
                f"{word} {value:.2g}"
                for word, value in zip(("distance", "by chance"), known, strict=True)
                if value is not None
            )
            panel.set_title(quantity["title"] + unit, pad=16, **_TITLE)
            panel.text(0, 1.03, note, transform=panel.transAxes, fontsize=8, color=FAINT)
        last, places = axes[-1], np.arange(len(labels["categories"]))
        for source, shift, colour in (("kitti", -0.2, _REAL), ("ours", 0.2, _OURS)):
            per_frame = [labels["objects_per_frame"][source][c] for c in labels["categories"]]
            last.barh(places + shift, per_frame, 0.38, color=colour)
        last.set_yticks(places, labels["categories"])
        last.invert_yaxis()
        last.set_title("Objects per frame", pad=16, **_TITLE)


@contextmanager
def _figure(path: Path, rows: int, columns: int, size: tuple[float, float]) -> Any:
    import matplotlib.pyplot as plt

    with plt.rc_context(_STYLE):
        figure, axes = plt.subplots(rows, columns, figsize=size, layout="constrained")
        yield np.ravel(axes)
        figure.savefig(path, dpi=100, facecolor="white")
        plt.close(figure)
