"""The figure of `docs/layouts.md`: generated layouts (blue) over KITTI (grey), panel by panel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from avsec_gym.drawing.figure_style import FAINT, FIGURE_STYLE, INK
from avsec_gym.geometry import Floats
from studies.world.layout_comparison import (
    LayoutComparison,
    OccupiedGoals,
    QuantityDistance,
    SizesByCategory,
)
from studies.world.layout_quantities import CATEGORIES, QUANTITIES, Quantity, Sample

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_OURS, _KITTI = "#0072B2", "#BDBDBD"
_PANELS = (
    "cars_per_frame people_per_frame objects occlusion",
    "distance lateral heading folded_heading",
    "car_height car_width car_length image_height",
    "truncated_share truncation people_distance people_lateral",
    "sizes sizes street highway",
)
_TICKS: Mapping[str, tuple[list[float], list[str]]] = {
    "heading": (
        [-np.pi, -np.pi / 2, 0, np.pi / 2, np.pi],
        ["−π", "−π/2\nahead", "0", "π/2\noncoming", "π"],
    ),
    "folded_heading": (
        [0, np.pi / 4, np.pi / 2, 3 * np.pi / 4, np.pi],
        ["0\nacross", "π/4", "π/2\nalong", "3π/4", "π\nacross"],
    ),
    "occlusion": ([0, 1, 2, 3], ["visible", "partly", "largely", "unknown"]),
    "truncated_share": ([0, 1], ["whole", "cut"]),
}
_STYLE = {
    **FIGURE_STYLE,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
}
_NAMES = {"Person_sitting": "Sitting"}


def draw(result: LayoutComparison, ours: Sample, kitti: Sample, path: Path) -> Path:
    """Write the figure.

    Args:
        result: What `compare_with_kitti` returns first.
        ours: The generated sample.
        kitti: The labelled one.
        path: Where the PNG goes.

    Returns:
        The path.
    """
    import matplotlib.pyplot as plt

    with plt.rc_context(_STYLE):
        layout: list[Any] = [row.split() for row in _PANELS]
        figure, panels = plt.subplot_mosaic(layout, figsize=(14, 15.5), empty_sentinel=".")
        figure.subplots_adjust(
            left=0.045, right=0.985, top=0.895, bottom=0.03, wspace=0.2, hspace=0.52
        )
        for name, axes in panels.items():
            axes.spines[["top", "right"]].set_visible(False)
            axes.tick_params(length=3)
            if name in QUANTITIES:
                _histogram(axes, name, result.quantities[name], ours, kitti)
            elif name == "objects":
                _objects(axes, result)
            elif name == "sizes":
                _sizes(axes, result.sizes)
            else:
                _goals(axes, name, result.occupied_goals[name])
        _head(figure, result)
        figure.savefig(path, dpi=120, facecolor="white")
        plt.close(figure)
    return path


def _head(figure: Figure, result: LayoutComparison) -> None:
    """Title and legend."""
    from matplotlib.patches import Patch

    figure.text(0.02, 0.975, "Generated layouts against KITTI", fontsize=18, weight="bold")
    figure.text(
        0.02,
        0.945,
        "Share of frames or objects in each bin, %; of vehicles (car, van, truck, misc) unless the "
        "title states otherwise.\nUnder each title: the distance between the two; as a yardstick "
        "that between two random halves of KITTI.",
        fontsize=10,
        color=FAINT,
        linespacing=1.4,
    )
    figure.legend(
        handles=[
            Patch(color=_KITTI, label=f"KITTI, {result.kitti_frames:,} frames"),
            Patch(color=_OURS, label=f"generated, {result.layouts.count:,} layouts"),
        ],
        loc="upper right",
        bbox_to_anchor=(0.99, 0.994),
        ncols=2,
        frameon=False,
        fontsize=10.5,
    )


def _title(axes: Axes, title: str, note: str) -> None:
    axes.set_title(title, loc="left", fontsize=11, weight="bold", color=INK, pad=20)
    axes.text(0, 1.035, note, transform=axes.transAxes, fontsize=8.5, color=FAINT)


def _histogram(
    axes: Axes, name: str, numbers: QuantityDistance, ours: Sample, kitti: Sample
) -> None:
    """One quantity: KITTI's histogram filled, ours as a line, or bars where it is discrete."""
    quantity = QUANTITIES[name]
    real, mine = (_shares(quantity, sample) for sample in (kitti, ours))
    if name in ("occlusion", "truncated_share"):
        _bars(axes, real, mine)
        axes.tick_params(axis="x", length=0)
    else:
        axes.stairs(real, quantity.edges, fill=True, color=_KITTI)
        axes.stairs(mine, quantity.edges, color=_OURS, linewidth=1.8)
        axes.set_xlim(quantity.edges[0], quantity.edges[-1])
    if name in _TICKS:
        axes.set_xticks(*_TICKS[name])
    axes.set_ylim(0, 1.08 * max(real.max(), mine.max()))
    continuous = quantity.kind == "wasserstein"
    unit = f" {quantity.unit}" if continuous and quantity.unit else ""
    kind = "Wasserstein" if continuous else "total variation"
    _title(
        axes,
        quantity.title + (f" ({quantity.unit})" if unit else ""),
        f"{kind} {numbers.distance:.2g}{unit}  (yardstick {numbers.yardstick:.2g})",
    )


def _shares(quantity: Quantity, sample: Sample) -> Floats:
    samples = quantity.measure(sample)
    counts = np.histogram(samples, quantity.edges)[0]
    return np.asarray(100.0 * counts / max(len(samples), 1))


def _bars(axes: Axes, real: Floats, mine: Floats) -> None:
    """Pairs of bars with their numbers on top."""
    place = np.arange(len(real))
    axes.bar(place - 0.2, real, 0.38, color=_KITTI)
    axes.bar(place + 0.2, mine, 0.38, color=_OURS)
    for x, value, colour in [
        *zip(place - 0.2, real, [FAINT] * len(real), strict=True),
        *zip(place + 0.2, mine, [_OURS] * len(mine), strict=True),
    ]:
        text = "0" if value == 0 else f"{value:.1f}" if value < 9.95 else f"{value:.0f}"
        axes.annotate(
            text,
            (x, value),
            xytext=(0, 2),
            textcoords="offset points",
            ha="center",
            fontsize=7,
            color=colour,
        )


def _objects(axes: Axes, result: LayoutComparison) -> None:
    """Mean number of objects of each category in a frame."""
    place = np.arange(len(CATEGORIES))
    widest = 0.0
    for per_frame, shift, colour, ink in (
        (result.objects_per_frame.kitti, -0.2, _KITTI, FAINT),
        (result.objects_per_frame.ours, 0.2, _OURS, _OURS),
    ):
        values = [per_frame[name] for name in CATEGORIES]
        axes.barh(place + shift, values, 0.38, color=colour)
        widest = max(widest, *values)
        for y, value in zip(place + shift, values, strict=True):
            axes.annotate(
                f"{value:.2f}",
                (value, y),
                xytext=(3, 0),
                textcoords="offset points",
                va="center",
                fontsize=7,
                color=ink,
            )
    _name_rows(axes, CATEGORIES)
    axes.set_xlim(0, 1.15 * widest)
    numbers = result.quantities["category"]
    note = f"total variation {numbers.distance:.2g}  (yardstick {numbers.yardstick:.2g})"
    _title(axes, "Objects per frame", note)


def _name_rows(axes: Axes, names: Sequence[str]) -> None:
    """Categories as row labels, with room for them to the left."""
    axes.set_yticks(range(len(names)), [_NAMES.get(name, name) for name in names])
    axes.tick_params(axis="y", length=0)
    axes.invert_yaxis()
    place = axes.get_position()
    axes.set_position((place.x0 + 0.05, place.y0, place.width - 0.05, place.height))


def _sizes(axes: Axes, sizes: SizesByCategory) -> None:
    """Median and the middle 80 % of the lengths of each category."""
    names = list(sizes.kitti)
    for known, shift, colour in ((sizes.kitti, -0.16, "#9A9A9A"), (sizes.ours, 0.16, _OURS)):
        for place, name in enumerate(names):
            if name in known:
                low, middle, high = known[name].length
                axes.plot([low, high], [place + shift] * 2, color=colour, linewidth=3, alpha=0.6)
                axes.plot(middle, place + shift, "o", color=colour, markersize=6)
    _name_rows(axes, names)
    axes.set_xlim(left=0)
    _title(axes, "Length by category (m)", "median and the middle 80 %; trams are not generated")


def _goals(axes: Axes, road_type: str, shares: OccupiedGoals) -> None:
    """How often an obstacle covers the centre of a goal region."""
    names = list(shares.ours)
    mine = np.array([100.0 * shares.ours[name] for name in names])
    known = shares.scenarios
    real = np.array([100.0 * known[name] for name in names]) if known else np.zeros(len(names))
    _bars(axes, real, mine)
    axes.set_xticks(range(len(names)), names)
    axes.tick_params(axis="x", length=0)
    axes.set_ylim(0, 12)
    apart = f"grey: labelled scenarios; at most {np.abs(mine - real).max():.1f} points apart"
    _title(axes, f"Occupied goals, {road_type} (%)", apart if known else "no scenarios given")
