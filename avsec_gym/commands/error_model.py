"""`avsec error-model fit` and `check`: what a detector gets wrong, as distributions."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from avsec_gym import console
from avsec_gym.errors import ConfigurationError

if TYPE_CHECKING:
    from avsec_gym.closed_loop.error_model.check import RangeCheck
    from avsec_gym.closed_loop.error_model.fit import DetectedFrame
    from avsec_gym.closed_loop.error_model.model import ErrorModel


@dataclass(frozen=True)
class ErrorModelFit:
    """Fit an error model to a detector's result files, for closed-loop drives without images.

    Misses by distance, occlusion and truncation; errors of place, heading and size; ghosts; and,
    where frames follow one another, how long each of these lasts.
    """

    kitti: tuple[Path, ...]
    """Labelled frames in KITTI's object layout; a vehicle's folder of a `connected` data set has
    frames that follow one another."""
    detections: tuple[Path, ...]
    """The detector's results for each of these folders, as `avsec detect` writes."""
    out: Path
    """JSON file of the error model: a new one."""
    split: str | None = None
    """The frames of ImageSets/SPLIT.txt, such as train.  Default: all that have labels."""
    limit: int | None = None
    """Only the first frames of each folder."""
    score_threshold: float = 0.3
    """Detections of a lower score are not planned on."""
    detector: str | None = None
    """The detector that found them, for the card, such as dsgn.  Default: as `avsec detect` has
    recorded."""
    attack: str | None = None
    """The attack on it, for the card.  Default: likewise."""
    json: bool = False
    """Print the model's card as JSON."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.closed_loop.error_model.fit import fit_error_model
        from avsec_gym.closed_loop.error_model.model import write_error_model

        frames = _frames(self)
        card = {**self._whose(), "score_threshold": self.score_threshold}
        model = fit_error_model(frames, card)
        write_error_model(self.out, model)
        if self.json:
            console.print_json("error-model.fit", {"out": str(self.out), **model.card})
        else:
            _show(model, str(self.out))
        return console.DONE

    def _whose(self) -> dict[str, Any]:
        """The detector, the hash of the weights that it had, and the attack, for the card."""
        from avsec_gym.perception.result_folder import recorded_detector

        recorded = [recorded_detector(folder) for folder in self.detections]
        if any(each != recorded[0] for each in recorded):
            raise ConfigurationError(
                "the folders of --detections hold results of several detectors, weights or attacks:"
                " fit a model to each"
            )
        whose = recorded[0]
        return {
            "detector": whose.detector if self.detector is None else self.detector,
            "weights": whose.weights,
            "attack": whose.attack if self.attack is None else self.attack,
        }


@dataclass(frozen=True)
class ErrorModelCheck:
    """Hold an error model against frames that it was not fitted to: misses and ghosts by distance.

    A distance agrees where the intervals of both differences lie within the margins; it differs
    where one lies outside; else the frames are too few to tell.  Exit code 3 unless all agree.
    """

    model: Annotated[str, tyro.conf.Positional]
    """JSON file of the error model, or the name of a shipped one, such as stereo_rcnn."""
    kitti: tuple[Path, ...]
    """Labelled frames in KITTI's object layout."""
    detections: tuple[Path, ...]
    """Results of the same detector, under the same attack, for each of these folders."""
    split: str | None = None
    """The frames of ImageSets/SPLIT.txt, such as val.  Default: all that have labels."""
    limit: int | None = None
    """Only the first frames of each folder."""
    score_threshold: float | None = None
    """Detections of a lower score are not planned on.  Default: the model's."""
    json: bool = False
    """Print the comparison as JSON."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.closed_loop.error_model.check import Agreement, check_error_model
        from avsec_gym.closed_loop.error_model.shipped import named_error_model

        model = named_error_model(self.model)
        threshold = self.score_threshold
        if threshold is None:
            threshold = float(model.card.get("score_threshold", 0.3))
        checks = check_error_model(model, _frames(self, threshold))
        agrees = all(each.answer == Agreement.AGREES for each in checks)
        if self.json:
            rows = [{**asdict(each), "answer": each.answer} for each in checks]
            console.print_json("error-model.check", {"ranges": rows, "agrees": agrees})
        else:
            console.print_table(
                f"{self.model} against {' '.join(map(str, self.detections))}",
                ["metres", "objects", "found %", "expected %", "ghosts a frame", "expected", ""],
                [_row(each) for each in checks],
            )
        return console.DONE if agrees else console.DONE_IN_PART


def _frames(
    asked: ErrorModelFit | ErrorModelCheck, threshold: float | None = None
) -> list[DetectedFrame]:
    from avsec_gym.closed_loop.error_model.stored_frames import stored_frames

    threshold = asked.score_threshold if threshold is None else threshold
    assert threshold is not None, "the model's, where none is asked for"
    if not 0 <= threshold <= 1:
        raise ConfigurationError(f"--score-threshold lies in [0, 1], got {threshold}")
    if asked.limit is not None and asked.limit < 1:
        raise ConfigurationError(f"--limit is 1 or more, got {asked.limit}")
    if len(asked.kitti) != len(asked.detections):
        raise ConfigurationError(
            f"--detections has a folder for each of --kitti: {len(asked.kitti)}, got"
            f" {len(asked.detections)}"
        )
    return [
        frame
        for kitti, detections in zip(asked.kitti, asked.detections, strict=True)
        for frame in stored_frames(
            kitti,
            detections,
            split=asked.split,
            limit=asked.limit,
            score_threshold=threshold,
        )
    ]


def _show(model: ErrorModel, name: str) -> None:
    import numpy as np

    card: dict[str, Any] = dict(model.card)
    rows = []
    for component, spread in model.spreads.items():
        near, far = spread.scales(np.array([10.0, 40.0]))
        rows.append([component, f"{spread.bias:+.3f}", f"{near:.3f}", f"{far:.3f}"])
    console.print_table(
        f"{name}: {card['found']} of {card['objects']} objects found, {card['ghosts']} ghosts in"
        f" {card['frames']} frames",
        ["error (m, rad)", "bias", "scale at 10 m", "at 40 m"],
        rows,
    )


def _row(check: RangeCheck) -> list[str]:
    def percent(share: float | None) -> str:
        return "-" if share is None else f"{100 * share:.1f}"

    return [
        f"{check.near:g} to {check.far:g}",
        str(check.objects),
        percent(check.found),
        percent(check.found_expected),
        f"{check.ghosts:.2f}",
        f"{check.ghosts_expected:.2f}",
        str(check.answer),
    ]
