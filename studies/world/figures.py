"""The figures of `studies/results/world.md`: rendered frames (blue) over real ones (grey)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from avsec_gym.drawing.figure_style import FAINT, FIGURE_STYLE
from avsec_gym.geometry import Floats
from studies.world.labels import LabelComparison
from studies.world.scans import ELEVATIONS, RANGES, REFLECTANCES, ScanComparison, ScanSpreads
from studies.world.stereo import MatcherErrors, RenderedPair

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_OURS, _REAL = "#0072B2", "#BDBDBD"
_MARKS = ["#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#8B4513", "#999900"]
_STYLE = {
    **FIGURE_STYLE,
    "axes.spines.top": False,
    "axes.spines.right": False,
}
_TITLE: dict[str, Any] = {"loc": "left", "fontsize": 10, "weight": "bold"}


def draw_stereo(
    rows: Sequence[RenderedPair], real: Mapping[str, MatcherErrors], path: Path
) -> None:
    """How hard pairs are: histograms of rendered ones, real ones as marks.

    Args:
        rows: The rows of `stereo.measure`.
        real: The result of `stereo.real_pairs`.
        path: Where the PNG goes.
    """
    lidar, dense = [row.lidar for row in rows], [row.dense for row in rows]
    panels: tuple[
        tuple[Callable[[MatcherErrors], float | None], str, range, list[MatcherErrors]], ...
    ]
    panels = (
        (lambda pair: pair.wrong, "Wrong of the found disparities (%)", range(31), lidar),
        (lambda pair: pair.density, "Found of the LiDAR's points (%)", range(60, 101), lidar),
        (lambda pair: pair.filled, "Found of all pixels (%)", range(50, 101), dense),
    )
    with _figure(path, 1, 3, (14, 3.6)) as axes:
        for (share, title, edges, pairs), panel in zip(panels, axes, strict=True):
            values = [100 * value for pair in pairs if (value := share(pair)) is not None]
            panel.hist(np.clip(values, edges[0], edges[-1]), edges, color=_OURS, alpha=0.75)
            panel.set_title(title, **_TITLE)
            panel.set_ylabel("rendered pairs")
            there = {key: value for key, pair in real.items() if (value := share(pair)) is not None}
            for colour, (key, value) in zip(cycle(_MARKS), there.items(), strict=False):
                label = f"real: {key.replace('_10', '')}"
                panel.axvline(100 * value, color=colour, linewidth=1.8, label=label)
            panel.legend(frameon=False, fontsize=8)


def draw_scans(scans: ScanComparison, path: Path) -> None:
    """Where a scan's points lie, and how bright they are.

    Args:
        scans: The result of `scans.summary`.
        path: Where the PNG goes.
    """
    even = np.arange(float(len(RANGES)))
    panels: tuple[tuple[Callable[[ScanSpreads], list[float]], str, float, Floats, Any], ...] = (
        (lambda of: of.range, "Range (m), % of points", 100.0, even, RANGES),
        (lambda of: of.elevation, "Elevation (degrees), % of points", 100.0, even, ELEVATIONS),
        (lambda of: of.reflectance, "Reflectance, % of points", 100.0, np.array(REFLECTANCES), ()),
        (lambda of: of.beams, "Points of each beam, from the top", 1.0, np.arange(65.0) - 0.5, ()),
    )
    with _figure(path, 1, 4, (16, 3.4)) as axes:
        for (numbers, title, scale, places, edges), panel in zip(panels, axes, strict=True):
            for source, colour, filled in ((scans.real, _REAL, True), (scans.scans, _OURS, False)):
                if source:
                    values = scale * np.array(numbers(source))
                    panel.stairs(values, places, fill=filled, color=colour, linewidth=1.8)
            if edges:
                panel.set_xticks(places, [f"{edge:g}" for edge in edges], fontsize=7)
            panel.set_title(title, **_TITLE)


def draw_labels(labels: LabelComparison, path: Path) -> None:
    """Histograms of all that is compared, and objects of each category.

    Args:
        labels: The result of `labels.summary`.
        path: Where the PNG goes.
    """
    quantities = {key: each for key, each in labels.quantities.items() if key != "category"}
    with _figure(path, 3, 4, (15, 9.5)) as axes:
        for panel, quantity in zip(axes, quantities.values(), strict=False):
            for shares, colour, filled in (
                (quantity.kitti, _REAL, True),
                (quantity.ours, _OURS, False),
            ):
                values = 100 * np.array(shares)
                panel.stairs(values, quantity.edges, fill=filled, color=colour, linewidth=1.8)
            unit = f" ({quantity.unit})" if quantity.unit else ""
            known = {"distance": quantity.distance, "by chance": quantity.yardstick}
            note = ", ".join(
                f"{word} {value:.2g}" for word, value in known.items() if value is not None
            )
            panel.set_title(quantity.title + unit, pad=16, **_TITLE)
            panel.text(0, 1.03, note, transform=panel.transAxes, fontsize=8, color=FAINT)
        last, places = axes[-1], np.arange(len(labels.categories))
        for per_frame, shift, colour in (
            (labels.objects_per_frame.kitti, -0.2, _REAL),
            (labels.objects_per_frame.ours, 0.2, _OURS),
        ):
            counts = [per_frame[category] for category in labels.categories]
            last.barh(places + shift, counts, 0.38, color=colour)
        last.set_yticks(places, labels.categories)
        last.invert_yaxis()
        last.set_title("Objects per frame", pad=16, **_TITLE)


@contextmanager
def _figure(
    path: Path, rows: int, columns: int, size: tuple[float, float]
) -> Iterator[Sequence[Axes]]:
    import matplotlib.pyplot as plt

    with plt.rc_context(_STYLE):
        figure, axes = plt.subplots(rows, columns, figsize=size, layout="constrained")
        yield list(np.ravel(axes))
        figure.savefig(path, dpi=100, facecolor="white")
        plt.close(figure)
