"""How networks were trained: the curves of their runs, thinned, with a picture.

Run ``python -m studies.perception.training_curves dsgn=runs/dsgn,runs/dsgn_2
stereo_rcnn=runs/stereo_rcnn --json FILE --figure PNG``; of trainings that went on with each
other's weights, the folders stand in a row.  ``--others FILE`` keeps what an earlier result has of
networks that are not trained anew; ``stereo_rcnn=+runs/stereo_rcnn_3`` goes on with what it has.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avsec_gym.drawing.figure_style import FIGURE_STYLE
from avsec_gym.drawing.scenario_picture import save_picture
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.experiments.json_rows import FLAT, OPTIONAL
from avsec_gym.perception.training.curves import CURVES, read_curves
from avsec_gym.storage.json_files import read_json_object
from studies.answer import answer

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NETWORKS = ("dsgn", "stereo_rcnn", "psmnet", "pixor", "pointrcnn", "faster_rcnn", "yolo")
"""Networks whose curves are shown."""
MOST_POINTS = 100
"""Most points of losses; each is the mean of as many rows as needed."""

_LEAVE_OUT = "Leave it out."
_SHOWN = {
    "Car_2d_ap11": "in the image",
    "Car_3d_ap11_iou50": "in space, IoU 0.5",
    "Car_bev_ap11_iou50": "from above, IoU 0.5",
    "Car_bev_ap11": "from above, IoU 0.7",
    "Car_3d_ap11": "in space, IoU 0.7",
    "right_3px": "right to 3 px and 5 %",
}
"""What is shown of the metrics, all in percent."""


@dataclass(frozen=True)
class LossPoint:
    """Means of the terms of a loss; None for what is not finite."""

    step: int
    """The last of those that they are the means of."""
    values: Mapping[str, float | None] = field(metadata=FLAT)


@dataclass(frozen=True)
class ValidationPoint:
    """The metrics of a validation; None for what is not finite."""

    step: int
    minutes: float
    values: Mapping[str, float | None] = field(metadata=FLAT)


@dataclass(frozen=True)
class NetworkCurves:
    """How a network was trained."""

    losses: Sequence[LossPoint]
    metrics: Sequence[ValidationPoint]
    begins: Sequence[int] | None = field(default=None, metadata=OPTIONAL)
    """Steps where trainings began that went on with the weights of others."""

    @classmethod
    def from_json(cls, curves: Mapping[str, Any]) -> NetworkCurves:
        """The curves of an earlier result.

        Raises:
            KeyError: It is none.
        """
        return cls(
            [LossPoint(row["step"], _without(row, "step")) for row in curves["losses"]],
            [
                ValidationPoint(row["step"], row["minutes"], _without(row, "step", "minutes"))
                for row in curves["metrics"]
            ],
            curves.get("begins"),
        )

    def rows(self) -> list[dict[str, Any]]:
        """The rows of `read_curves`, with the rows of `joined`."""
        begins = [
            {"step": step, "begins": number} for number, step in enumerate(self.begins or (), 2)
        ]
        losses = [{"step": point.step, "losses": _known(point.values)} for point in self.losses]
        metrics = [
            {"step": point.step, "seconds": 60 * point.minutes, "metrics": _known(point.values)}
            for point in self.metrics
        ]
        return sorted([*begins, *losses, *metrics], key=lambda row: row["step"])


def run(options: argparse.Namespace) -> dict[str, NetworkCurves]:
    """Read, thin, draw.

    Raises:
        ConfigurationError: A run is not given as ``name=FOLDER``, or none is given.
        DataError: A folder holds no curves, or the earlier result is not one.
    """
    before = {} if options.others is None else _others(options.others)
    trained: dict[str, NetworkCurves] = {}
    for text in options.runs or _below(options.below):
        name, _, folder = text.partition("=")
        if not (name and folder):
            raise ConfigurationError(f"a run is given as name=FOLDER, got {text!r}")
        parts = folder.removeprefix("+").split(",")
        trainings = [_curves(Path(part)) for part in parts]
        if folder.startswith("+"):
            if name not in before:
                raise ConfigurationError(f"{text}: --others has nothing of {name} to go on with")
            trainings.insert(0, _earlier(before[name], options.others).rows())
        trained[name] = thinned_curves(joined(trainings))
    result = {
        name: trained[name] if name in trained else _earlier(before[name], options.others)
        for name in dict.fromkeys((*before, *trained))
    }
    if options.figure is not None:
        save_picture(_figure(result), options.figure, overwrite=True)
    return result


def _below(folder: Path | None) -> list[str]:
    """Runs that are named as networks, and as NETWORK_2 if they went on with another's weights."""
    if folder is None:
        raise ConfigurationError("no run is named: give name=FOLDER, or --below FOLDER")
    parts = {name: [folder / name, folder / f"{name}_2"] for name in NETWORKS}
    trained = {
        name: [folder for folder in both if (folder / CURVES).is_file()]
        for name, both in parts.items()
    }
    if not any(trained.values()):
        raise DataError(
            "There is no run of a network.", path=folder, remedy="`avsec train` writes them."
        )
    return [f"{name}={','.join(map(str, found))}" for name, found in trained.items() if found]


def _others(file: Path) -> dict[str, Any]:
    return read_json_object(file, remedy=_LEAVE_OUT)


def _earlier(curves: Any, file: Path) -> NetworkCurves:
    try:
        return NetworkCurves.from_json(curves)
    except (KeyError, TypeError, ValueError) as error:
        raise DataError(
            "This is no earlier result of trainings.", path=file, remedy=_LEAVE_OUT
        ) from error


def joined(trainings: Sequence[Sequence[Mapping[str, Any]]]) -> list[dict[str, Any]]:
    """The rows of trainings, each of which began with the best weights of the one before.

    Steps and seconds go on; a row ``{"step": ..., "begins": n}`` stands where the n-th begins.
    """
    rows: list[dict[str, Any]] = []
    step, seconds = 0, 0.0
    for number, training in enumerate(trainings, start=1):
        if number > 1:
            rows.append({"step": step, "begins": number})
        for row in training:
            rows.append({**row, "step": step + row["step"]})
            if "seconds" in row:
                rows[-1]["seconds"] = seconds + row["seconds"]
        step = rows[-1]["step"]
        seconds = max((row["seconds"] for row in rows if "seconds" in row), default=0.0)
    return rows


def _curves(folder: Path) -> list[dict[str, Any]]:
    rows = read_curves(folder)
    if not rows:
        raise DataError(
            f"There is no {CURVES} of a training.",
            path=folder,
            remedy="`avsec train` writes it.",
        )
    return rows


def thinned_curves(rows: Sequence[Mapping[str, Any]], most: int = MOST_POINTS) -> NetworkCurves:
    """Every validation, and means of the losses.

    Args:
        rows: The rows of `read_curves`.
        most: Points that are left of the losses.
    """
    logged = [row for row in rows if "losses" in row]
    every = max(1, math.ceil(len(logged) / most))
    losses = []
    for first in range(0, len(logged), every):
        part = logged[first : first + every]
        names = dict.fromkeys(name for row in part for name in row["losses"])
        means = {
            name: _mean([row["losses"][name] for row in part if name in row["losses"]])
            for name in names
        }
        losses.append(LossPoint(part[-1]["step"], means))
    metrics = [
        ValidationPoint(
            row["step"],
            round(row["seconds"] / 60, 1),
            {name: _mean([value]) for name, value in row["metrics"].items()},
        )
        for row in rows
        if "metrics" in row
    ]
    return NetworkCurves(losses, metrics, [row["step"] for row in rows if "begins" in row] or None)


def _without(row: Mapping[str, Any], *names: str) -> dict[str, float | None]:
    return {name: value for name, value in row.items() if name not in names}


def _known(values: Mapping[str, float | None]) -> dict[str, float]:
    return {name: value for name, value in values.items() if value is not None}


def _mean(values: Sequence[float]) -> float | None:
    mean = sum(values) / len(values)
    return round(mean, 5) if math.isfinite(mean) else None


def _figure(curves: Mapping[str, NetworkCurves]) -> Figure:
    """A row for each network: its loss, its validation."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    style = {**FIGURE_STYLE, "axes.spines.top": False, "axes.spines.right": False}
    with mpl.rc_context(style):
        figure = Figure(figsize=(10, 2.4 * len(curves)), dpi=110, layout="constrained")
        panels = figure.subplots(len(curves), 2, squeeze=False, sharex="row")
        for (left, right), (name, curve) in zip(panels, curves.items(), strict=True):
            left.plot(*_points(curve.losses, "total"), color="#0072B2", lw=1.4)
            left.set_title(f"{name}: loss", loc="left", size=9)
            for metric, title in _SHOWN.items():
                if any(metric in point.values for point in curve.metrics):
                    right.plot(*_points(curve.metrics, metric), marker=".", lw=1.4, label=title)
            known = "%" if right.lines else "none on the way"
            right.set_title(f"{name}: validation, {known}", loc="left", size=9)
            right.set_ylim(0, 1.05 * max(right.dataLim.y1, 1.0))
            for axes in (left, right):
                for step in curve.begins or ():
                    axes.axvline(step, color="grey", lw=0.8, ls=":")
            if right.lines:
                # Beside the panel: curves may run anywhere in it.
                right.legend(frameon=False, fontsize=7, loc="upper left", bbox_to_anchor=(1, 1))
            else:
                right.set_axis_off()
        for axes in panels[-1]:
            axes.set_xlabel("steps")
    return figure


def _points(
    points: Sequence[LossPoint] | Sequence[ValidationPoint], name: str
) -> tuple[list[int], list[float]]:
    known = [
        (point.step, value) for point in points if (value := point.values.get(name)) is not None
    ]
    return [step for step, _ in known], [value for _, value in known]


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("runs", nargs="*", help="name=FOLDER of `avsec train`")
    parser.add_argument("--below", type=Path, help="instead: the folder of runs named as networks")
    parser.add_argument(
        "--others", type=Path, help="result of before: other networks stay as there"
    )
    parser.add_argument("--figure", type=Path, help="PNG")
    parser.add_argument("--json", type=Path, help="file for the result; default: standard output")
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
