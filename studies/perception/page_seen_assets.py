"""The part of detectors.md on the assets that networks have seen in their trainings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from avsec_gym.report.markdown_table import markdown_table, number
from studies.perception.page_frames import in_words
from studies.perception.training_history import SeenFrames, Training

FIRST_EDITION = "631bd73bde61982a"
"""Fingerprint of the world whose assets were not divided; its bodies of cars are all gone."""
_FIRST, _TRAIN, _UNKNOWN = "first edition", "training assets", "not recorded"
_PARTS = {"judge": "judging assets", "all": "all assets", "train": _TRAIN}
_COUNTED_AS = ("judging assets", "all assets", _FIRST, _UNKNOWN, _TRAIN)
"""A training with frames of several parts counts as the first of these."""


def seen_assets(trainings: Sequence[Training]) -> list[str]:
    """How many images of which assets each network has learned from."""
    seen: dict[str, Counter[str]] = {}
    for leg in trainings:
        seen.setdefault(leg.network, Counter())[_part(leg.learned)] += leg.images or 0
    if not seen:
        return []
    shown = [part for part in _COUNTED_AS if any(part in images for images in seen.values())]
    rows = [
        [
            f"`{network}`",
            number(images.total(), 0),
            *(number(images[part], 0) for part in shown),
        ]
        for network, images in seen.items()
    ]
    return [
        "## Which assets the networks have seen",
        "",
        "Frames to judge on are made of [judging assets](../../docs/world.md), data to train on of"
        " training assets. The world's first edition was not divided: its frames show houses,"
        " plants, furniture and textures some of which, altered or not, are judging assets today."
        " Of its cars none is left, since all bodies were made anew before the division. So the"
        " [comparison of both parts](#by-assets) is one of new cars, and of all else that is new"
        " only as far as a network had not begun on the first edition.",
        "",
        "Images that each network learned from, by the assets of their frames. Not recorded are"
        " those of weights that no commit brought, whose card is lost.",
        "",
        *markdown_table(["network", "images", *shown], rows),
        "",
        _summary(seen),
    ]


def _part(learned: Iterable[SeenFrames]) -> str:
    """The part of the assets that counts of a training."""
    parts = {_part_of(source) for source in learned} or {_UNKNOWN}
    return min(parts, key=_COUNTED_AS.index)


def _part_of(source: SeenFrames) -> str:
    if source.assets is not None:
        return _PARTS[source.assets]
    return _FIRST if source.fingerprint == FIRST_EDITION else _UNKNOWN


def _summary(seen: Mapping[str, Counter[str]]) -> str:
    """Which networks have seen nothing of the judging assets, some of their houses, or more."""
    kinds: dict[str, list[str]] = {}
    for network, images in seen.items():
        kinds.setdefault(_kind(images), []).append(f"`{network}`")
    return " ".join(f"{in_words(kinds[kind])} {kind}." for kind in _KINDS if kind in kinds)


_TRAINED = "learned from training assets alone, as far as it is recorded"
_BEGAN = (
    "began on the first edition and went on with training assets: of the judging assets, houses"
    " and the like were seen, and no car"
)
_FIRST_ALONE = "learned from the first edition alone"
_JUDGED = "**learned from judging assets, cars among them**"
_KINDS = (_TRAINED, _BEGAN, _FIRST_ALONE, _JUDGED)


def _kind(images: Counter[str]) -> str:
    if images[_PARTS["judge"]] or images[_PARTS["all"]]:
        return _JUDGED
    if not images[_FIRST]:
        return _TRAINED
    return _BEGAN if images[_FIRST] < images.total() else _FIRST_ALONE
