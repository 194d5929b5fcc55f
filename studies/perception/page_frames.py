"""Frames that were judged on, as a page names them: assets, command, and who has seen them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from studies.perception.kept_detections import LabelledData
from studies.perception.training_history import SeenFrames, Training
from studies.perception.weights_facts import SourceFacts, WeightsFacts

_ASSETS = {"all": "all assets", "train": "training assets", "judge": "judging assets"}


def assets_of(data: LabelledData) -> str:
    """The part of the assets that the scenes are made of."""
    return _ASSETS[data.assets or "all"]


def world_make(data: LabelledData) -> str:
    """The command that makes these frames, but for the folder and the sensors."""
    return (
        f"avsec world make --suite {data.suite} --frames {data.frames} --seed {data.seed}"
        f" --assets {data.assets or 'all'}"
    )


def held_out(
    data: LabelledData,
    weights: Mapping[str, WeightsFacts | None],
    trainings: Iterable[Training],
) -> str:
    """Whether a network has learned from the layouts of frames, which suite and seed draw.

    Args:
        data: The frames.
        weights: Network -> what its card states, which is of its last training.
        trainings: All trainings that are known.
    """
    sources: list[SeenFrames | SourceFacts] = []
    for card in weights.values():
        if card is not None:
            sources += [*card.data.training, *card.data.validation]
    legs = [each for each in trainings if each.network in weights]
    for leg in legs:
        sources += [*leg.learned, *leg.validated, *leg.calibrated]
    known = {
        (source.suite, source.seed)
        for source in sources
        if source.suite is not None and source.seed is not None
    }
    if not known:
        return "No card states what the detectors learned from."
    if (data.suite, data.seed) in known:
        return "**Not held out: a detector was trained or validated on this suite and seed.**"
    lost = sum(not leg.learned for leg in legs)
    return (
        "The networks were trained, validated and calibrated on others"
        f" ({_suites_and_seeds(known)}{_not_recorded(lost)})."
    )


def _suites_and_seeds(known: Iterable[tuple[str, int]]) -> str:
    """Such as: suite `mixed`, seeds 1 and 11."""
    seeds: dict[str, list[int]] = {}
    for suite, seed in sorted(known):
        seeds.setdefault(suite, []).append(seed)
    return "; ".join(
        f"suite `{suite}`, seed{'s' * (len(drawn) > 1)} {in_words(map(str, drawn))}"
        for suite, drawn in seeds.items()
    )


def _not_recorded(trainings: int) -> str:
    if not trainings:
        return ""
    return f"; of {trainings} training{'s' * (trainings > 1)} no card records the frames"


def in_words(items: Iterable[str]) -> str:
    """Such as: one, two and three."""
    *some, last = items
    return f"{', '.join(some)} and {last}" if some else last


def frames_in_words(sources: Sequence[SeenFrames]) -> str:
    """Such as: 640 frames of `mixed`, seed 7306; nothing where there are none."""
    return "; ".join(
        ("" if source.frames is None else f"{source.frames} ")
        + f"frames of `{source.suite}`, seed {source.seed}"
        for source in sources
    )
