"""What the diagrams of chapter 3 run over, and the options that size them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from avsec_gym.argument_checks import number, one_of, whole_number
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.diagrams.variant import (
    CAMERA,
    FORMS,
    LIGHTS,
    Variant,
)
from avsec_gym.experiments.chapter3.objects.detector_weights import WEIGHT_OPTIONS
from avsec_gym.experiments.chapter3.recordings import PART_OPTIONS
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.evidence.pair_depth import PairDepth

MATCHERS: Mapping[str, str | Mapping[str, Any]] = {
    "sgbm": "sgbm",
    "sgbm_filled": {"name": "sgbm", "filled": True},
    "psmnet": "psmnet",
    "psmnet_published": {"name": "psmnet", "configuration": "full"},
}
"""Semi-global matching; the same with its holes filled; the package's small PSMNet; and one of full
size, whose weights a user gives."""
PUBLISHED = "psmnet_published"
DIAGRAM_OPTIONS: dict[str, Any] = {
    **PART_OPTIONS,
    "matchers": "sgbm,sgbm_filled,psmnet",
    PUBLISHED: "",
    "scans": [0, 10_000],
    "forms": ",".join(FORMS),
    "points": [0, 1000, 3000, 10_000],
    "lights": ",".join(LIGHTS),
    "sizes": [0.02, 0.044, 0.088, 0.2],
    "strengths": [16.0, 64.0, 255.0, 1275.0],
    "believers": "pixor,pointrcnn",
    "image_detector": "faster_rcnn",
    **{name: WEIGHT_OPTIONS[name] for name in ("pixor", "pointrcnn", "faster_rcnn")},
}
"""Options beside `PART_OPTIONS`: ``matchers``: some of `MATCHERS`, with commas;
``psmnet_published``: a file of a published PSMNet's weights; ``scans``: how many points are left of
the LiDAR's scan, 0 for all; ``forms`` of bogus objects, with commas, and ``points`` of them, 0 for
as many as the LiDAR's own beams meet; ``lights``, with commas, their ``sizes``, radii in shares of
the image's width, and ``strengths``, grey levels at the peak; ``believers``: detectors that look at
scans, with commas, of which the first is compared with images, none if empty; ``image_detector``:
what looks at images; by the networks' names their weights."""
_MOST = 10_000_000


def matchers_of(options: Mapping[str, Any]) -> dict[str, PairDepth]:
    """The depth of pairs by the matchers' names.

    Args:
        options: Values of `DIAGRAM_OPTIONS`.

    Raises:
        ConfigurationError: No such matcher, or the published one without weights.
    """
    found = {}
    for name in _names(options, "matchers", MATCHERS):
        what = MATCHERS[name]
        if name == PUBLISHED:
            if not options[PUBLISHED]:
                raise ConfigurationError(
                    f"{PUBLISHED} takes the file of its weights, as of `avsec weights import`:"
                    f" --options {PUBLISHED}=FILE"
                )
            assert not isinstance(what, str)
            what = {**what, "weights": options[PUBLISHED]}
        found[name] = PairDepth(what)
    return found


def variants_of(options: Mapping[str, Any]) -> list[Variant]:
    """All attacks of a run: bogus objects in every scan, lights with the first of the scans.

    Args:
        options: Values of `DIAGRAM_OPTIONS`.

    Raises:
        ConfigurationError: A name or number that cannot be.
    """
    scans = scans_of(options)
    points = _numbers(options, "points")
    objects = [
        Variant(LIDAR, form, count, scan=scan)
        for scan in scans
        for form in _names(options, "forms", FORMS)
        for count in (whole_number("points", each, 0, _MOST) for each in points)
    ]
    lights = [
        Variant(CAMERA, light, number("strengths", strength, 0.01, 100_000.0), size, scans[0])
        for light in _names(options, "lights", LIGHTS)
        for size in (number("sizes", each, 1e-4, 10.0) for each in _numbers(options, "sizes"))
        for strength in _numbers(options, "strengths")
    ]
    return objects + lights


def scans_of(options: Mapping[str, Any]) -> list[int]:
    """How many points are left of the scan, 0 for all.

    Raises:
        ConfigurationError: A number that cannot be, or none.
    """
    return [whole_number("scans", each, 0, _MOST) for each in _numbers(options, "scans")]


def believers_of(options: Mapping[str, Any]) -> list[str]:
    """The names of the detectors that look at scans."""
    return str(options["believers"]).split(",")


def _names(options: Mapping[str, Any], name: str, known: Mapping[str, Any]) -> Iterator[str]:
    for each in dict.fromkeys(str(options[name]).split(",")):
        yield one_of(f"{name[:-1]} among --options {name}", each, known)


def _numbers(options: Mapping[str, Any], name: str) -> list[Any]:
    found = options[name]
    if not found:
        raise ConfigurationError(f"--options {name} takes one number or more")
    return list(dict.fromkeys(found))
