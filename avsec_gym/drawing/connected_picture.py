"""A picture of an alarm of connected vehicles, from above: claims, and rays that pass through."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from avsec_gym.drawing.figure_style import as_drawn
from avsec_gym.geometry import Floats
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.folders import make_folder
from avsec_gym.validation.connected.rays.claims import claim
from avsec_gym.validation.connected.rays.observer import Observer, observe
from avsec_gym.validation.connected.rays.ray_outcomes import SUPPORT, THROUGH
from avsec_gym.validation.connected.rays.witness import WitnessMargins, outcomes
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

VEHICLE_COLOURS = ("#1F77B4", "#E8871E", "#2A9D5C", "#8E5BB5", "#8A5A44", "#D45BA0")
_ACCUSED, _UNTOLD, _QUIET = "#D7263D", "#B8860B", "#9A9A9A"
_MOST_ZOOMED = 3
_AROUND = 9.0
"""Metres around an accused region that its own picture shows."""
_MOST_RAYS = 40
_LINE = 11
"""Points between the names of two vehicles at one place."""
_HEIGHTS = (0.25, 2.5)
"""Metres above the regions' ground between which points are drawn: what stands, not the road."""


def draw_connected(
    result: ConnectedResult,
    scans: Sequence[VehicleScan],
    margins: WitnessMargins = WitnessMargins(),
    origin: str = "",
    about: Sequence[int] = (),
) -> Figure:
    """Left: all scans from above.  Right: the regions that alarm, likeliest first, three at most.

    There, squares are what each vehicle claims, in its colour; a red line is a witness' ray that
    passes through a claim, a green one a ray that ends on what is claimed.

    Args:
        result: What was decided.
        scans: The scans that it was decided of.
        margins: What may lie apart.
        origin: Data that the constants were fitted on, in words.
        about: Indices of regions that come before all others, such as those of a known attack.
    """
    from matplotlib.figure import Figure

    shown = sorted(result.accusations, key=lambda each: each.index not in about)[:_MOST_ZOOMED]
    rows = max(len(shown), 1)
    figure = Figure(figsize=(13.5, max(6.5, 3.6 * rows)), layout="constrained")
    grid = figure.add_gridspec(rows, 2, width_ratios=[1.6, 1.0])
    whole = figure.add_subplot(grid[:, 0])
    _draw_all(whole, result, scans, [each.index for each in shown])
    observers = [observe(scan) for scan in scans] if shown else []
    for row, accused in enumerate(shown):
        axes = figure.add_subplot(grid[row, 1])
        region = result.regions[np.array([accused.index])]
        _draw_region(axes, region, observers, margins)
        who = "cannot tell whose" if accused.vehicle < 0 else f"vehicle {accused.vehicle}"
        axes.set_title(
            f"{chr(65 + row)}: {accused.kind}, {who}, probability {accused.probability:.2f}",
            fontsize=10,
        )
    heading = f"{result.id}   {_status(result)}   by {result.method}"
    heading = heading if not origin else f"{heading}\n{origin}"
    figure.suptitle(as_drawn(heading), fontsize=10)
    return figure


def save_connected_picture(
    path: Path,
    result: ConnectedResult,
    scans: Sequence[VehicleScan],
    margins: WitnessMargins = WitnessMargins(),
    origin: str = "",
    about: Sequence[int] = (),
) -> None:
    """Write `draw_connected` as PNG.

    Raises:
        DataError: The file cannot be written.
    """
    import io

    content = io.BytesIO()
    draw_connected(result, scans, margins, origin, about).savefig(content, format="png", dpi=90)
    make_folder(path.parent)
    write_bytes(path, content.getvalue(), overwrite=True)


def _status(result: ConnectedResult) -> str:
    if not result.alarm:
        return "no alarm"
    named = ", ".join(map(str, result.accused))
    return f"alarm: vehicle {named} is attacked" if named else "alarm: cannot tell whose LiDAR"


def _draw_all(
    axes: Axes, result: ConnectedResult, scans: Sequence[VehicleScan], zoomed: Sequence[int]
) -> None:
    """All vehicles, what stands around them, and the regions; those that are zoomed by letters."""
    ground = float(np.median(result.regions.centre[:, 2])) if len(result.regions) else None
    places = np.array([scan.pose[:2, 3] for scan in scans])
    # Each vehicle, and what stands up in its scan.
    for number, scan in enumerate(scans):
        points = scan.in_world()
        level = scan.pose[2, 3] - 1.73 if ground is None else ground
        height = points[:, 2] - level
        stands = points[(height > _HEIGHTS[0]) & (height < _HEIGHTS[1])]
        colour = VEHICLE_COLOURS[number % len(VEHICLE_COLOURS)]
        axes.plot(*stands[::2, :2].T, ",", color=colour, alpha=0.5)
        axes.plot(*places[number], marker=(3, 0, _degrees(scan.pose) - 90), ms=13, color=colour)
        axes.annotate(
            f"vehicle {number}",
            (places[number, 0], places[number, 1]),
            # One above the other: successive scans of one vehicle are a metre or two apart.
            (9, 7 + _LINE * number),
            textcoords="offset points",
            color=colour,
            fontweight="bold",
        )
    # The regions; those with a panel of their own have its letter.
    accused = {each.index for each in result.accusations}
    for index in range(len(result.regions)):
        corners = _corners(result.regions, index)
        if index not in accused:
            axes.plot(*corners.T, color=_QUIET, lw=0.8)
            continue
        colour = _UNTOLD if result.named[index] < 0 else _ACCUSED
        axes.plot(*corners.T, color=colour, lw=2.2)
        if index in zoomed:
            axes.annotate(
                chr(65 + zoomed.index(index)),
                (result.regions.centre[index, 0], result.regions.centre[index, 1]),
                (8, 8),
                textcoords="offset points",
                color=colour,
                fontsize=13,
                fontweight="bold",
            )
    # As far as all vehicles, and what stands around them.
    middle, reach = places.mean(axis=0), max(float(np.ptp(places, axis=0).max()) / 2 + 30, 45)
    axes.set_xlim(middle[0] - reach, middle[0] + reach)
    axes.set_ylim(middle[1] - reach, middle[1] + reach)
    _metres(axes)
    axes.set_title(
        "red: attacked, ochre: attacked, whose is not clear, grey: compared or not seen twice",
        fontsize=9,
    )


def _draw_region(
    axes: Axes, region: Regions, observers: Sequence[Observer], margins: WitnessMargins
) -> None:
    """Claims of all vehicles in a region, and what the rays of all others do there."""
    for number, observer in enumerate(observers):
        claims = claim(observer, region)
        places = claims.places(region)
        colour = VEHICLE_COLOURS[number % len(VEHICLE_COLOURS)]
        for witness in observers:
            if witness is observer or not len(claims):
                continue
            outcome = outcomes(witness, claims, region, margins)
            for kind, line in ((THROUGH, _ACCUSED), (SUPPORT, VEHICLE_COLOURS[2])):
                met = places[outcome == kind]
                for place in met[:: max(1, len(met) // _MOST_RAYS)]:
                    _draw_ray(axes, witness.pose[:2, 3], place[:2], line, beyond=kind == THROUGH)
        if len(claims):
            axes.plot(*places[:, :2].T, "s", ms=4, color=colour, label=f"claimed by {number}")
    axes.plot(*_corners(region, 0).T, color=_ACCUSED, lw=1.8)
    x, y = region.centre[0, :2]
    axes.set_xlim(x - _AROUND, x + _AROUND)
    axes.set_ylim(y - _AROUND / 2, y + _AROUND / 2)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper right", fontsize=8)
    _metres(axes)


def _draw_ray(axes: Axes, origin: Floats, place: Floats, colour: str, beyond: bool) -> None:
    along = place - origin
    end = place + (4.0 if beyond else 0.0) * along / max(float(np.hypot(*along)), 1e-6)
    axes.plot([origin[0], end[0]], [origin[1], end[1]], color=colour, lw=0.5, alpha=0.55)


def _corners(regions: Regions, index: int) -> Floats:
    """The closed outline of a region from above, shape (5, 2)."""
    length, width = regions.size[index, :2] / 2
    cos, sin = np.cos(regions.heading[index]), np.sin(regions.heading[index])
    own = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]]) * [length, width]
    return np.asarray(own @ [[cos, sin], [-sin, cos]] + regions.centre[index, :2])


def _degrees(pose: Floats) -> float:
    return float(np.degrees(np.arctan2(pose[1, 0], pose[0, 0])))


def _metres(axes: Any) -> None:
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlabel("x of the common world, m", fontsize=8)
    axes.set_ylabel("y, m", fontsize=8)
    axes.tick_params(labelsize=7)
