"""The gallery of docs/world_made.md: frames, the truth beside them, scans, styles, assets.

Run ``python -m studies.world.gallery --out docs/images``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.drawing.frame_picture import (
    depth_picture,
    points_in_image,
    surface_picture,
    titled,
    view_from_above,
    with_boxes,
)
from avsec_gym.errors import DataError
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.rig import SensorRig, kitti_rig, resized_rig
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.world.assets import Assets
from avsec_gym.world.capture import Capture, Lidar, render
from avsec_gym.world.drives import drive_scenes
from avsec_gym.world.export import line_numbers
from avsec_gym.world.layouts import layout_by_id
from avsec_gym.world.posed_scenes import posed_scene_of_labels, posed_scene_of_layout
from avsec_gym.world.site import Style
from studies.answer import exit_code
from studies.world.light_steps import light_steps
from studies.world.panels import panel_sheet
from studies.world.seen_from_above import connected_picture

STREET, HIGHWAY, CAMPUS = "street-000021", "highway-000045", "street-000006"
PARKED = "street-000012"
"""Layouts that are shown; the default suite `mixed` has them under the same numbers."""

_STYLES = (Style.CITY, Style.RESIDENTIAL, Style.CAMPUS, Style.RURAL)
_DRIVE = 1
"""Number of the drive in which vehicles are connected."""
_VEHICLES = 3
_BESIDE = 0.4
"""Width of the land that a scan from above shows, as a share of its length."""
_QUALITY = 80
"""Quality of JPEG: all pictures of the page together have about a megabyte."""


def frame_of(id: str, rig: SensorRig) -> Image:
    """What camera 2 sees of a layout."""
    return _capture(id, rig).images[2]


def steps(rig: SensorRig) -> Image:
    """How the street comes about; see `light_steps`."""
    layout = layout_by_id(STREET)
    return light_steps(layout, posed_scene_of_layout(layout, rig), rig.size[0])


def truth(rig: SensorRig) -> Image:
    """The street with all that is known of its pixels."""
    capture = _capture(STREET, rig)
    image, boxes = capture.images[2], capture.labels.boxes
    panels = {
        "labels": with_boxes(image, boxes, rig.calibration, 2),
        "disparity": depth_picture(capture.disparity),
        "surfaces": surface_picture(image, capture.geometry.surface),
        "instances: numbers of the label lines": instance_picture(image, line_numbers(capture)),
    }
    return panel_sheet(panels, 2, rig.size[0])


def scan(rig: SensorRig) -> Image:
    """The street as the LiDAR sees it: in the image, and from above."""
    capture = _capture(STREET, rig, Lidar())
    assert capture.scan is not None
    frame = SensorFrame(STREET, rig.calibration, capture.images, capture.scan.points)
    seen = points_in_image(frame.image(2), frame, 2)
    # The vehicle looks to the right, and the land far to its sides is left out.
    above = np.rot90(view_from_above(frame, capture.labels.boxes, rig.size[0]), -1)
    beside = (above.shape[0] - round(_BESIDE * above.shape[1])) // 2
    return np.concatenate(
        [
            titled(seen, "LiDAR in the image, by distance"),
            titled(above[beside:-beside, : seen.shape[1]], "the same from above, by height"),
        ]
    )


def connected(rig: SensorRig) -> Image:
    """Three vehicles at one instant: their images, and their scans together."""
    posed = drive_scenes(seed=0, index=_DRIVE, frames=1, egos=_VEHICLES, rig=rig)[0]
    captures = [render(posed, ego=ego, cameras=(2,)) for ego in range(_VEHICLES)]
    seen = {f"vehicle {number}": each.images[2] for number, each in enumerate(captures)}
    row = panel_sheet(seen, _VEHICLES, rig.size[0])
    scans = [each.scan for each in captures if each.scan is not None]
    above = connected_picture(posed, scans, row.shape[1], round(_BESIDE * row.shape[1]))
    return np.concatenate([row, above])


def styles(rig: SensorRig) -> Image:
    """The same labelled objects in places of four styles."""
    boxes = layout_by_id(STREET).boxes
    return panel_sheet(
        {
            str(style): render(
                posed_scene_of_labels(boxes, rig, seed=0, style=style), cameras=(2,), lidar=None
            ).images[2]
            for style in _STYLES
        },
        2,
        rig.size[0],
    )


def assets(rig: SensorRig) -> Image:
    """Two layouts with each part of the assets."""
    return panel_sheet(
        {
            f"{id}, --assets {part}": _capture(id, rig, assets=part).images[2]
            for id in (PARKED, CAMPUS)
            for part in (Assets.TRAIN, Assets.JUDGE)
        },
        2,
        rig.size[0],
    )


PICTURES: dict[str, Callable[[SensorRig], Image]] = {
    "world_steps": steps,
    "world_street": lambda rig: frame_of(STREET, rig),
    "world_highway": lambda rig: frame_of(HIGHWAY, rig),
    "world_campus": lambda rig: frame_of(CAMPUS, rig),
    "world_truth": truth,
    "world_scan": scan,
    "world_connected": connected,
    "world_styles": styles,
    "world_assets": assets,
}
"""Name of the file, without its ending, to what draws it with a rig."""


def instance_picture(image: Image, numbers: NDArray[np.uint16]) -> Image:
    """Each object in a colour of its own over a darkened image.

    Args:
        image: Shape (H, W, 3).
        numbers: Number of the object of each pixel, 0 for none, shape (H, W).
    """
    import matplotlib as mpl

    colours = (np.array(mpl.colormaps["tab20"].colors) * 255).astype(np.uint8)  # type: ignore[attr-defined]
    chosen = colours[(numbers.astype(int) - 1) % len(colours)]
    return np.where((numbers > 0)[..., None], chosen, (0.4 * image).astype(np.uint8))


def _capture(
    id: str, rig: SensorRig, lidar: Lidar | None = None, assets: Assets = Assets.ALL
) -> Capture:
    posed = posed_scene_of_layout(layout_by_id(id), rig, assets)
    return render(posed, cameras=(2,), lidar=lidar)


def write_picture(path: Path, picture: Image) -> None:
    """Write a JPEG over what is there.

    Raises:
        DataError: The file cannot be written.
    """
    quality = [cv2.IMWRITE_JPEG_QUALITY, _QUALITY]
    done, content = cv2.imencode(".jpg", np.ascontiguousarray(picture[..., ::-1]), quality)
    if not done:
        raise DataError("OpenCV cannot encode this picture.", path=path, remedy="Report it.")
    write_bytes(path, content.tobytes(), overwrite=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("."), help="folder")
    parser.add_argument("--width", type=int, default=1242, help="of the images, pixels")
    parser.add_argument("--only", nargs="+", choices=PICTURES, default=list(PICTURES))
    options = parser.parse_args(arguments)

    def work() -> None:
        rig = resized_rig(kitti_rig(), options.width)
        for name in options.only:
            write_picture(options.out / f"{name}.jpg", PICTURES[name](rig))

    return exit_code(work)


if __name__ == "__main__":
    sys.exit(main())
