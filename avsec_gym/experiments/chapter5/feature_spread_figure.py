"""The thesis' figure 5.8: what a patch changes in the feature maps of each detector."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from avsec_gym.drawing.figure_style import FAINT, FIGURE_STYLE
from avsec_gym.experiments.chapter5.feature_spread import FeatureSpread


def draw_feature_spread(spreads: Mapping[str, FeatureSpread], path: str | Path) -> None:
    """A row of maps for each detector, each map from 0 to its own maximum (figure 5.8).

    Under each: the radius that it counts as changed, in multiples of the patch's, by its own
    maximum, and by what another image would change.

    Args:
        spreads: The feature maps by their titles.
        path: The picture's file.
    """
    columns = 1 + max(len(spread.layers) for spread in spreads.values())
    with matplotlib.rc_context(FIGURE_STYLE):
        figure = Figure(figsize=(1.15 * columns, 1.85 * len(spreads)), facecolor="white")
        axes = figure.subplots(len(spreads), columns, squeeze=False)
        for axis in axes.flat:
            axis.axis("off")
        for row, (title, spread) in zip(axes, spreads.items(), strict=True):
            row[0].imshow(spread.image)
            row[0].set_title("Input", fontsize=8)
            row[0].annotate(title, (0, 1.3), xycoords="axes fraction", fontsize=8, weight="bold")
            for axis, layer in zip(row[1:], spread.layers, strict=False):
                axis.imshow(layer.difference, cmap="inferno", vmin=0)
                axis.set_title(layer.layer, fontsize=8)
                radii = (layer.extent.radius, layer.extent.radius_absolute)
                text = " / ".join(f"{radius / spread.patch_radius:.1f}" for radius in radii)
                axis.text(
                    *(0.5, -0.06, text),
                    transform=axis.transAxes,
                    fontsize=7,
                    color=FAINT,
                    ha="center",
                    va="top",
                )
        figure.subplots_adjust(0.01, 0.1, 0.99, 0.82, wspace=0.06, hspace=0.62)
        figure.savefig(path, dpi=150, bbox_inches="tight")
