"""Names that results had before, and the names that stand for them now.

Results outlive the code that made them.  A run that was made under an old name is read, reported
and continued under the new one.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from avsec_gym.errors import ConfigurationError

EXPERIMENTS: Mapping[str, str] = {"knowing": "adaptive_attacks"}
"""Old name of an experiment -> its name."""

_EXPERIMENTS = "avsec_gym.experiments"
_CHAPTER_3 = f"{_EXPERIMENTS}.chapter3"
WORKS: Mapping[str, str] = {
    f"{_CHAPTER_3}.identification.knowing_attackers:KnowingAttackers": (
        f"{_CHAPTER_3}.identification.adaptive_attacks:AdaptiveAttacks"
    ),
    f"{_CHAPTER_3}.localisation.repaired_moments:RepairedMoments": (
        f"{_CHAPTER_3}.localisation.repaired_frames:RepairedFrames"
    ),
    f"{_CHAPTER_3}.defence.defended_drives:DefendedDrives": (
        f"{_CHAPTER_3}.defence.defended_episodes:DefendedEpisodes"
    ),
    f"{_EXPERIMENTS}.chapter5.attacked_drives:AttackedDrives": (
        f"{_EXPERIMENTS}.chapter5.attacked_episodes:AttackedEpisodes"
    ),
    f"{_EXPERIMENTS}.chapter5.true_drives:TrueDrives": (
        f"{_EXPERIMENTS}.chapter5.true_episodes:TrueEpisodes"
    ),
    f"{_EXPERIMENTS}.pipeline_drives:PipelineDrives": (
        f"{_EXPERIMENTS}.pipeline_episodes:PipelineEpisodes"
    ),
}
"""Old place of a work -> its place.  A cell keeps the id that it had under the old one."""

KEYS: Mapping[str, Mapping[str, str]] = {
    "identification": {
        "moments": "frames",
        "noticed": "detected",
        "noticed_by_error": "detected_by_error",
        "told": "reported",
        "honesty": "calibration",
        "verdicts": "statuses",
        "said": "predicted",
        "was": "observed",
        **EXPERIMENTS,
    },
    "five_sensors": {"moments": "frames", "told": "reported"},
    "object_level": {"moments": "frames"},
    "impact": {"moments": "frames"},
    "sensitivity": {"moments": "frames"},
    "localisation": {"moments": "frames", "moment": "frame"},
    "other_pairs": {"moments": "frames"},
    "identification_real": {"moments": "frames"},
    "shipped_fits": {"nobody": "no attack"},
    "chapter5_errors": {"mended": "corrected", "stakes": "headroom"},
}
"""Keys by experiment or study: old key of its figures -> the key."""

_THESIS_PGD: Mapping[str, str] = {
    "pgd-0.4": "thesis_pgd-0.4",
    "pgd-1": "thesis_pgd-1",
    "texture-pgd-1": "texture-thesis_pgd-1",
}
SETTINGS: Mapping[str, Mapping[str, str]] = dict.fromkeys(
    ("demo", "chapter5", "perturbation", "inputs", "texture", "ghost_positions"), _THESIS_PGD
)
"""Words by experiment: old word of a setting -> the word; cells' arguments have these words,
too."""
PARTS: Mapping[str, Mapping[str, str]] = {"pipeline": {"pgd": "thesis_pgd"}}
"""Names by experiment: old name of a part in the run's options -> its name."""

_BOTH_FORMS = (
    "'pgd' changes its meaning to the projected form of Madry et al., in version 0.2 the attack"
    " 'projected_pgd'; 'thesis_pgd' is the form of the thesis, which is not projected"
)


def with_new_keys(figures: Any, renamed: Mapping[str, str]) -> Any:
    """The figures of an earlier release under the keys of this one; values stay as they are.

    Args:
        figures: What JSON can state.
        renamed: Old key -> new key, one of `KEYS`.

    Example:
        >>> with_new_keys({"rows": [{"told": 0.5}]}, KEYS["five_sensors"])
        {'rows': [{'reported': 0.5}]}
    """
    if isinstance(figures, dict):
        return {
            renamed.get(key, key): with_new_keys(value, renamed) for key, value in figures.items()
        }
    if isinstance(figures, list):
        return [with_new_keys(value, renamed) for value in figures]
    return figures


def with_new_names(figures: Any, renamed: Mapping[str, str]) -> Any:
    """The same where keys and texts have the names of this one.

    Args:
        figures: What JSON can state.
        renamed: Old name -> name, one of `SETTINGS` or `PARTS`.

    Example:
        >>> with_new_names([{"attack": "pgd-1"}, "pgd-10"], SETTINGS["demo"])
        [{'attack': 'thesis_pgd-1'}, 'pgd-10']
    """
    if isinstance(figures, dict):
        return {
            renamed.get(key, key): with_new_names(value, renamed) for key, value in figures.items()
        }
    if isinstance(figures, list):
        return [with_new_names(value, renamed) for value in figures]
    return renamed.get(figures, figures) if isinstance(figures, str) else figures


def new_setting(setting: str, renamed: Mapping[str, str]) -> str:
    """A setting in the new words.

    Example:
        >>> new_setting("dsgn pgd-0.4 8-bit", SETTINGS["demo"])
        'dsgn thesis_pgd-0.4 8-bit'
    """
    return " ".join(renamed.get(word, word) for word in setting.split(" "))


def check_setting(setting: str, experiments: Collection[str]) -> None:
    """Refuse a setting of an old name.

    Args:
        setting: A setting that was asked for, and that the run does not have.
        experiments: Names of the run's experiments.

    Raises:
        ConfigurationError: It is one; the message has the new name.
    """
    for experiment in experiments:
        if (new := new_setting(setting, SETTINGS.get(experiment, {}))) != setting:
            raise ConfigurationError(
                f"the setting {setting!r} is called {new!r} now: {_BOTH_FORMS}"
            )


def first_place(work: str) -> str:
    """The place where a work stood first, on which the ids of its cells depend.

    Args:
        work: The place where it stands now.
    """
    return _FIRST_PLACES.get(work, work)


_FIRST_PLACES = {new: old for old, new in WORKS.items()}
