"""Pictures as an MP4 that browsers play; PyAV encodes it."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Image


def check_video() -> None:
    """Refuse to begin what could not be encoded.

    Raises:
        ConfigurationError: PyAV is not installed.
    """
    try:
        import av  # noqa: F401
    except ImportError:
        raise ConfigurationError(
            "an MP4 is encoded by PyAV: pip install 'avsec-gym[video]'; a GIF needs nothing more"
        ) from None


def mp4(images: Sequence[Image], rate: int) -> bytes:
    """The file's bytes: H.264.

    Args:
        images: Pictures of one size, red, green and blue.
        rate: Pictures in a second.

    Raises:
        ConfigurationError: PyAV is not installed.
    """
    check_video()
    import av

    # The codec wants even sizes.
    height, width = (side - side % 2 for side in images[0].shape[:2])
    content = io.BytesIO()
    with av.open(content, "w", format="mp4") as container:
        stream = container.add_stream("libx264", rate=rate)
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        for image in images:
            whole = np.ascontiguousarray(image[:height, :width])
            container.mux(stream.encode(av.VideoFrame.from_ndarray(whole, format="rgb24")))
        container.mux(stream.encode())
    return content.getvalue()
