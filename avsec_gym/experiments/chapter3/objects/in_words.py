"""What a run of chapter 3 says of detectors under optical attacks, in sentences."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avsec_gym.drawing.page_table import number
from avsec_gym.experiments.chapter3.objects.attack_sizes import CAMERA
from avsec_gym.experiments.chapter3.objects.believed_points import PASTED_RAYS_LOST, PLANE
from avsec_gym.experiments.chapter3.objects.tables import SHOWN_LEVEL, detector_words
from avsec_gym.sensor_system import LIDAR

_RATE = 0.01


def optical_sentences(summaries: Mapping[str, Any]) -> list[str]:
    """Of the parts that a run has figures of.

    Args:
        summaries: See `avsec_gym.experiments.chapter3.objects.tables.tables_of_optical_attacks`.
    """
    sentences = []
    if summaries.get("baseline"):
        for row in summaries["baseline"]["rows"]:
            if (row["iou"], row["rate"]) == (0.5, _RATE):
                sentences.append(
                    f"Objects of {row['scenario']} tell of {_percent(row['average'])} of the"
                    f" attacks, with {_percent(row['false_alarms']['rate'])} false alarms (IoU 0.5,"
                    " r = 1 %)."
                )
    if summaries.get("impact"):
        sentences += _impact(summaries["impact"])
    if summaries.get("believed"):
        sentences += _believed(summaries["believed"])
    if summaries.get("sensitivity"):
        sentences += [_sizes(what, summaries["sensitivity"][what]) for what in (LIDAR, CAMERA)]
    return sentences


def _impact(impact: Mapping[str, Any]) -> list[str]:
    lidar, camera = impact["lidar"], impact["camera"]
    sentences = [
        f"{detector_words(lidar['detector'])} takes the bogus return for an obstacle in"
        f" {lidar['taken']['count']:,} of {lidar['taken']['of']:,} moments; without the attack it"
        f" has one there in {lidar['clean']['count']:,}."
    ]
    if camera is not None:
        values = [camera[name][SHOWN_LEVEL]["value"] for name in ("clean", "attacked")]
        sentences.append(
            f"A facula lowers {detector_words(camera['detector'])}’s AP of cars from"
            f" {number(values[0], digits=2)} to {number(values[1], digits=2)} % ({SHOWN_LEVEL},"
            f" IoU {camera['iou']:g})."
        )
    return sentences


def _believed(summary: Mapping[str, Any]) -> list[str]:
    sentences = []
    for detector in summary["objects"]:
        told = {row["kind"]: row for row in summary["rows"] if row["detector"] == detector}
        plane = _percent(told[PLANE]["newly"]["rate"])
        said = (
            f"{detector_words(detector)} is led to see an obstacle by {plane} of the bogus planes"
        )
        if PASTED_RAYS_LOST in told:
            car = _percent(told[PASTED_RAYS_LOST]["newly"]["rate"])
            said += f", and by {car} of the scans of cars that hide what is behind them"
        sentences.append(f"{said}.")
    return sentences


def _sizes(what: str, told: Mapping[str, Any]) -> str:
    unit = "px" if what == CAMERA else "m"
    first, last = told["sizes"][1], told["sizes"][-1]
    noticed = [_percent(row["detected"]["any"]["rate"]) for row in (first, last)]
    sentence = (
        f"{'Faculae' if what == CAMERA else 'Bogus returns'} of {first['size']:g} to"
        f" {last['size']:g} {unit} are noticed in {noticed[0]} to {noticed[1]} of the moments"
    )
    if last["precision"] is None:
        return f"{sentence}."
    lost = [number(row["precision"][SHOWN_LEVEL]["lost"], digits=2) for row in (first, last)]
    return (
        f"{sentence}; they cost {detector_words(told['detector'])} {lost[0]} to {lost[1]} points"
        " of AP."
    )


def _percent(share: float) -> str:
    return f"{number(share, 100, 2)} %"
