"""Frames that were judged on, as a page names them: their designs, and what makes them."""

from __future__ import annotations

from studies.perception.kept_detections import LabelledData

_DESIGNS = {
    "all": "all designs",
    "train": "the designs that networks are trained on",
    "judge": "designs that no network was trained on",
}


def designs(data: LabelledData) -> str:
    """Which designs the scenes are made of."""
    return _DESIGNS[data.assets or "all"]


def world_make(data: LabelledData) -> str:
    """The command that makes these frames, but for the folder and the sensors."""
    return (
        f"avsec world make --suite {data.suite} --frames {data.frames} --seed {data.seed}"
        f" --assets {data.assets or 'all'}"
    )
