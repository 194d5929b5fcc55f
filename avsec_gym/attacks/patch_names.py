"""Which names patches have; nothing here loads torch."""

from __future__ import annotations

from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.storage.regular_files import is_file, is_there
from avsec_gym.unknown_source import unknown_source

CONTROLS = ("grey", "noise")
"""Names of patches that are not trained."""
PATCHES = Path(__file__).parent / "patches"
"""The folder of the patches that come with the package."""


def patch_names() -> tuple[str, ...]:
    """The names that stand for patches: the controls, and those that come with the package.

    Example:
        >>> patch_names()
        ('grey', 'noise', 'dsgn', 'joint', 'stereo_rcnn')
    """
    return (*CONTROLS, *sorted(path.stem for path in PATCHES.glob("*.safetensors")))


def check_patch_name(patch: str | Path) -> None:
    """Refuse what is neither a name nor a file; no file is read.

    Args:
        patch: A name of `patch_names`, or a file.

    Raises:
        ConfigurationError: It is a mistyped name.
        DataError: There is no such file.
    """
    names = patch_names()
    expected = f"Name a file that `avsec attack patch` made, or one of {', '.join(names)}."
    if str(patch) in names or is_file(patch):
        return
    if is_there(patch):
        raise DataError("This is no file.", path=patch, remedy=expected)
    raise unknown_source(str(patch), names, expected, "patch")
