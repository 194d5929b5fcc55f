"""The part of detectors.md on the weights' cards and the curves of their trainings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from avsec_gym.report.markdown_table import UNKNOWN, markdown_table, number
from studies.perception.detector_precision import ScoredDetector
from studies.perception.disparity_accuracy import DisparityAccuracy
from studies.perception.page_frames import frames_in_words, in_words
from studies.perception.single_sensor_precision import SingleSensorPrecision
from studies.perception.training_curves import NetworkCurves, ValidationPoint
from studies.perception.training_history import Training
from studies.perception.weights_facts import SourceFacts

_VALIDATED = {
    "Car_3d_ap11": "AP11 in space",
    "Car_bev_ap11": "AP11 from above",
    "Car_2d_ap11": "AP11 in the image",
    "right_3px": "right to 3 px and 5 %",
}


def training(
    detectors: Mapping[str, ScoredDetector],
    single: SingleSensorPrecision | None,
    disparity: DisparityAccuracy | None,
    curves: Mapping[str, NetworkCurves] | None,
    known: Sequence[Training] = (),
) -> list[str]:
    """What the cards of the weights state, and the curves.

    Args:
        detectors: The results of `detector_precision`.
        single: The results of `single_sensor_precision`.
        disparity: The results of `disparity_accuracy`, whose network has a card, too.
        curves: The curves of `training_curves`.
        known: All trainings of `training_history`, which knows on what frames a card's metric is.
    """
    cards = {name: figures.weights for name, figures in detectors.items()}
    if single:
        cards |= {name: figures.weights for name, figures in single.detectors.items()}
    cards["psmnet"] = disparity.weights if disparity else None
    there = {name: card for name, card in cards.items() if card}
    if not there:
        return []
    legs = {leg.sha256: leg for leg in known}
    rows = [
        [
            f"`{name}`",
            number(card.parameters, 0),
            number(card.bytes / 1e6, 1),
            _frames(card.data.training),
            _frames(card.data.validation),
            f"{_in_all([each.epochs for each in card.trainings])};"
            f" {_in_all([each.steps for each in card.trainings])}",
            number(card.seed, 0),
            _validated(card.metrics),
            _measured_on(legs.get(card.sha256)),
            _before_calibration(card.metrics, legs.get(card.sha256), (curves or {}).get(name)),
            f"`{card.sha256[:12]}`",
        ]
        for name, card in there.items()
    ]
    lines = [
        "## Training",
        "",
        "By the cards beside the weights: of the best validation, or the last (`--keep last`)."
        " Frames are those of the last training, epochs and steps those of all. Where scores were"
        " calibrated, which is done after a training, a card's precision is that on the very"
        " frames of the calibration, in place of that of the validation. Calibrating keeps the"
        " order of scores, and with it the precision, of all networks but Stereo R-CNN, whose"
        " scores then also count evidence, by weights that were fitted to these frames. No card"
        " keeps the precision before: it stands here where the curves hold a validation at the last"
        " step.",
        "",
        *markdown_table(
            ["network", "parameters", "MB", "trained on", "validated on", "epochs; steps",
             "seed", "precision", "measured on", "before calibration, on the validation's",
             "sha256"],
            rows,
        ),
        "",
        "```",
        *(each.command for card in there.values() for each in card.trainings if each.command),
        "```",
    ]  # fmt: skip
    if curves:
        lines += [
            "",
            "The numbers of the curves are in [detector_training.json](detector_training.json)."
            f" {_still_rising(curves)}",
            "",
            "![Loss and validation over steps](images/detector_training.png)",
        ]
    return lines


def _measured_on(leg: Training | None) -> str:
    """The frames that a card's metric is of."""
    if leg is None:
        return UNKNOWN
    words = frames_in_words(leg.measured_on) or UNKNOWN
    return f"{words}, calibrated on them" if leg.calibrated else words


def _before_calibration(
    metrics: Mapping[str, float], leg: Training | None, curves: NetworkCurves | None
) -> str:
    """The metric at a training's last step, on its validation frames, before it was calibrated."""
    if leg is None or curves is None or not leg.calibrated:
        return UNKNOWN
    last = _of_last_training(curves)
    if not last or last[-1].step < curves.losses[-1].step:
        return UNKNOWN
    leading = next((name for name in metrics if name in _VALIDATED), "")
    return number(last[-1].values.get(leading), 1)


def _of_last_training(curves: NetworkCurves) -> list[ValidationPoint]:
    """The validations since the last of several trainings began."""
    begun = (curves.begins or [0])[-1]
    return [point for point in curves.metrics if point.step > begun]


def _still_rising(curves: Mapping[str, NetworkCurves]) -> str:
    """What validations tell of the end of the last trainings."""
    few = [f"`{name}`" for name, curve in curves.items() if len(_of_last_training(curve)) < 2]
    counts = ", ".join(f"`{name}` {len(curve.metrics)}" for name, curve in curves.items())
    text = f"Validations that they hold, of all trainings: {counts}."
    if not few:
        return text
    return (
        f"{text} Fewer than two of them are of the last training of {in_words(few)}: whether it"
        " could have gone on rising can be known from the losses only, which flatten where the"
        " learning rate ends at its least."
    )


def _in_all(counts: Sequence[float | None]) -> str:
    """The sum over the trainings that made the weights, up to their best validations."""
    known = [count for count in counts if count is not None]
    return UNKNOWN if len(known) < len(counts) else number(sum(known), 0)


def _frames(sources: Sequence[SourceFacts]) -> str:
    known = []
    for source in sources:
        known.append(f"{source.frames} frames of `{source.suite}`, seed {source.seed}")
        if source.baseline:
            known[-1] += f", {100 * source.baseline:.0f} cm between the cameras"
    return "; ".join(known) or UNKNOWN


def _validated(metrics: Mapping[str, float]) -> str:
    """Of the metric that leads, which a card states first."""
    for name, value in metrics.items():
        if name in _VALIDATED:
            return f"{_VALIDATED[name]} {value:.1f}"
    return UNKNOWN
