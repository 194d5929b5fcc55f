"""Lists of images with a label of 0 or 1, as the authors of the labelled scenarios write them."""

from __future__ import annotations

from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.road_type import RoadType
from avsec_gym.storage.text_files import read_text

HEAD = "img_name,label"
ROAD_TYPES = {1: RoadType.STREET, 0: RoadType.HIGHWAY}
"""What the labels of a list of road types mean."""


def read_label_list(path: Path) -> dict[str, int]:
    """Labels by image, such as ``000107`` or ``000001_0d``, in the file's order.

    Raises:
        DataError: The file cannot be read, or a line is broken.
    """
    head, *lines = read_text(path).splitlines() or [""]
    if head.strip() != HEAD:
        raise DataError(f"The first line is not {HEAD!r}.", path=path, line=1)
    result = {}
    for number, line in enumerate(lines, 2):
        if not line.strip():
            continue
        name, _, label = line.partition(",")
        if label.strip() not in ("0", "1"):
            raise DataError(
                f"{line.strip()!r} is no image with a label.",
                path=path,
                line=number,
                remedy="A line is an image and 0 or 1, such as 000107.png,1.",
            )
        result[Path(name.strip()).stem] = int(label)
    return result
