"""`avsec world sheet` and `avsec world show`: pictures of data sets, procedural or real."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from avsec_gym import console
from avsec_gym.argument_checks import whole_number
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.storage.regular_files import is_file, is_folder

if TYPE_CHECKING:
    from avsec_gym.boxes import Boxes3D
    from avsec_gym.frame import Image, SensorFrame
    from avsec_gym.kitti.dataset import KittiObject
    from avsec_gym.kitti.raw import Drive

_MOST_FRAMES, _MOST_COLUMNS, _WIDEST = 1000, 100, 2000
"""Limits of one sheet: frames, frames in a row, and pixels of a frame."""
_LONGEST_SIDE = 65_500
"""Pixels that JPEG takes."""


@dataclass(frozen=True)
class WorldSheet:
    """Many frames of a data set on one picture."""

    root: Annotated[Path | None, tyro.conf.Positional] = None
    """KITTI object or raw folder.  Default: the mixed suite, made on first use."""
    out: Path = Path("out/world_sheet.jpg")
    """Picture file, .png or .jpg."""
    frames: int = 24
    """How many, 1000 at most, evenly spread over the data set."""
    columns: int = 4
    """Frames in a row."""
    camera: int = 2
    """The camera whose images are shown."""
    width: int = 480
    """Width of each frame, pixels."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.drawing.frame_picture import contact_sheet

        whole_number("--frames", self.frames, 1, _MOST_FRAMES)
        whole_number("--columns", self.columns, 1, _MOST_COLUMNS)
        whole_number("--width", self.width, 16, _WIDEST)
        data = _open(self.root)
        names = _names(data, f"image_{self.camera}")
        count = min(self.frames, len(names))
        picked = [names[index * len(names) // count] for index in range(count)]
        with console.progress("reading") as shown:
            images = []
            for number, name in enumerate(picked):
                images.append(_frame(data, name).image(self.camera))
                shown(number + 1, count)
        _write(self.out, contact_sheet(images, columns=self.columns, width=self.width))
        return console.DONE


@dataclass(frozen=True)
class WorldShow:
    """One frame with all its sensors: labels, depth, LiDAR, surfaces, and from above."""

    root: Annotated[Path | None, tyro.conf.Positional] = None
    """KITTI object or raw folder or one drive, real or procedural.  Default: the mixed suite."""
    id: str | None = None
    """Frame, such as 000107, or its number in a drive.  Default: the first with labels."""
    out: Path = Path("out/world_frame.jpg")
    """Picture file, .png or .jpg; or .rrd, a recording for the Rerun viewer (extra `rerun`), with
    images, scan and labels in space."""
    camera: int = 2
    """The reference camera."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.drawing.frame_picture import frame_picture
        from avsec_gym.frame import LazyImages
        from avsec_gym.kitti.dataset import KittiObject
        from avsec_gym.kitti.map_files import read_disparity, read_mask

        data = _open(self.root)
        name = self.id or _names(data, f"image_{self.camera}")[0]
        frame = _frame(data, name)
        if self.out.suffix == ".rrd":
            from avsec_gym.drawing.rerun_frame import write_frame_recording

            write_frame_recording(frame, self.out, _labels(data, name))
            console.say(f"{self.out}: frame {frame.id}, for the Rerun viewer")
            return console.DONE
        # Maps that a rendered data set has beside its images; real ones have none.
        if isinstance(data, KittiObject):
            beside = [data.folder / f"{kind}_{self.camera}" for kind in ("disparity", "surface")]
            files = [folder / f"{name}.png" for folder in beside]
        else:
            beside = [
                data.folder / f"{kind}_{self.camera:02d}" for kind in ("disparity", "surface")
            ]
            files = [folder / "data" / f"{int(name):010d}.png" for folder in beside]
        disparity = read_disparity(files[0]) if is_file(files[0]) else None
        surfaces = read_mask(files[1]).astype("uint8") if is_file(files[1]) else None
        # A picture joins them pixel by pixel: all have to be of one size.
        of_image = frame.image(self.camera).shape[:2]
        for file, beside_it in zip(files, (disparity, surfaces), strict=True):
            if beside_it is not None:
                _check_size(file, beside_it.shape[:2], of_image)
        partner = self.camera + 1
        if partner in frame.images:
            own = frame.images.path(partner) if isinstance(frame.images, LazyImages) else None
            _check_size(own, frame.image(partner).shape[:2], of_image)
        picture = frame_picture(
            frame,
            _labels(data, name),
            disparity,
            surfaces,
            camera=self.camera,
            partner=partner,
        )
        _write(self.out, picture)
        return console.DONE


def _check_size(file: Path | None, size: tuple[int, ...], image: tuple[int, ...]) -> None:
    """Refuse what does not fit the reference camera's image, pixel by pixel.

    Raises:
        DataError: Its height or width, in pixels, is another one.
    """
    if size != image:
        height, width = size
        raise DataError(
            f"It is of {width} x {height} pixels, the reference camera's image of {image[1]} x"
            f" {image[0]}.",
            path=file,
            remedy="Write both anew, of one size.",
        )


def _open(root: Path | None) -> KittiObject | Drive:
    from avsec_gym.kitti.dataset import KittiObject
    from avsec_gym.kitti.layouts import KittiLayout, recognise
    from avsec_gym.kitti.raw import KittiRaw

    if root is None:
        from avsec_gym.world.export import default_suite

        with console.progress("rendering the mixed suite, once") as shown:
            return KittiObject(default_suite("mixed", on_progress=shown))
    if is_folder(root / "vehicle_0"):
        root = root / "vehicle_0"
    if recognise(root) == KittiLayout.RAW:
        raw = KittiRaw(root)
        drives = [raw.drive(name) for name in raw.drives()]
        return max(drives, key=lambda drive: len(drive.sensors.get("image_02", ())))
    return KittiObject(root)


def _names(data: KittiObject | Drive, images: str) -> list[str]:
    from avsec_gym.kitti.dataset import KittiObject

    if isinstance(data, KittiObject):
        names = data.ids(having=[images])
    else:
        camera = int(images.rpartition("_")[2])
        names = [str(number) for number in data.frames(having=[f"image_{camera:02d}"])]
    if not names:
        raise DataError(
            f"No frame here has a file in {images}/.",
            path=data.folder,
            remedy="Name another --camera, or another folder.",
        )
    return names


def _frame(data: KittiObject | Drive, name: str) -> SensorFrame:
    from avsec_gym.kitti.dataset import KittiObject

    if isinstance(data, KittiObject):
        return data.frame(name)
    if not name.isdecimal():
        raise ConfigurationError(f"--id of a drive is a number, got {name!r}")
    return data.frame(int(name), previous=0)


def _labels(data: KittiObject | Drive, name: str) -> Boxes3D | None:
    from avsec_gym.kitti.dataset import KittiObject

    try:
        return data.labels(name) if isinstance(data, KittiObject) else data.labels(int(name))
    except DataError as error:
        console.say(f"without labels: {error}")
        return None


def _write(path: Path, picture: Image) -> None:
    import cv2

    from avsec_gym.storage.atomic_write import write_bytes

    if path.suffix.lower() not in (".png", ".jpg", ".jpeg"):
        raise ConfigurationError(f"--out ends in .png, .jpg or, of one frame, .rrd; got {path}")
    if max(picture.shape) > _LONGEST_SIDE:
        raise ConfigurationError(
            f"a picture's sides have {_LONGEST_SIDE:,} pixels at most, this one's "
            f"{picture.shape[1]:,} x {picture.shape[0]:,}: take fewer --frames, or less --width"
        )
    _, content = cv2.imencode(path.suffix, picture[..., ::-1])
    write_bytes(path, content.tobytes(), overwrite=True)
    console.say(f"{path}: {picture.shape[1]} x {picture.shape[0]} pixels")
