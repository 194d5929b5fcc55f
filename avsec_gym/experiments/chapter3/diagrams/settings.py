"""What the diagrams of chapter 3 run over, and the options that size them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
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
from avsec_gym.runs.experiment import Configuration
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


@dataclass(frozen=True)
class DiagramSettings:
    """`DIAGRAM_OPTIONS` of a run, each name and number one that can be.

    Args:
        matchers: Some of `MATCHERS`.
        published: The file of a published PSMNet's weights; empty: none is given.
        scans: How many points are left of the scan, 0 for all; one or more.
        forms: Some of `FORMS`.
        points: How many points a bogus object has, 0 for as many as the LiDAR's own beams meet.
        lights: Some of `LIGHTS`.
        sizes: Radii of lights, in shares of the image's width.
        strengths: Grey levels at the peak of lights.
        believers: Detectors that look at scans; the first is compared with images.
        image_detector: The detector that looks at images.
        weights: What `WEIGHT_OPTIONS` give to networks, by their names.
    """

    matchers: Sequence[str]
    published: str
    scans: Sequence[int]
    forms: Sequence[str]
    points: Sequence[int]
    lights: Sequence[str]
    sizes: Sequence[float]
    strengths: Sequence[float]
    believers: Sequence[str]
    image_detector: str
    weights: Mapping[str, str]

    @classmethod
    def of(cls, configuration: Configuration) -> DiagramSettings:
        """The settings of a run.

        Raises:
            ConfigurationError: A name or number that cannot be, or none.
        """
        options = {**DIAGRAM_OPTIONS, **configuration.options}
        believers = str(options["believers"])
        return cls(
            _names(options, "matchers", MATCHERS),
            str(options[PUBLISHED]),
            [whole_number("scans", each, 0, _MOST) for each in _numbers(options, "scans")],
            _names(options, "forms", FORMS),
            [whole_number("points", each, 0, _MOST) for each in _numbers(options, "points")],
            _names(options, "lights", LIGHTS),
            [number("sizes", each, 1e-4, 10.0) for each in _numbers(options, "sizes")],
            [number("strengths", each, 0.01, 1e5) for each in _numbers(options, "strengths")],
            believers.split(",") if believers else (),
            str(options["image_detector"]),
            {name: options[name] for name in WEIGHT_OPTIONS if name in options},
        )

    def depths(self) -> dict[str, PairDepth]:
        """The depth of pairs by the matchers' names.

        Raises:
            ConfigurationError: The published network is to match, and has no weights.
        """
        found = {}
        for name in self.matchers:
            what = MATCHERS[name]
            if name == PUBLISHED:
                if not self.published:
                    raise ConfigurationError(
                        f"{PUBLISHED} takes the file of its weights, as of `avsec weights import`:"
                        f" --options {PUBLISHED}=FILE"
                    )
                assert not isinstance(what, str)
                what = {**what, "weights": self.published}
            found[name] = PairDepth(what)
        return found

    def variants(self) -> list[Variant]:
        """All attacks of a run: bogus objects in every scan, lights with the first of the scans."""
        objects = [
            Variant(LIDAR, form, count, scan=scan)
            for scan in self.scans
            for form in self.forms
            for count in self.points
        ]
        lights = [
            Variant(CAMERA, light, strength, size, self.scans[0])
            for light in self.lights
            for size in self.sizes
            for strength in self.strengths
        ]
        return objects + lights


def _names(options: Mapping[str, Any], name: str, known: Mapping[str, Any]) -> list[str]:
    found = dict.fromkeys(str(options[name]).split(","))
    return [one_of(f"{name[:-1]} among --options {name}", each, known) for each in found]


def _numbers(options: Mapping[str, Any], name: str) -> list[Any]:
    found = options[name]
    if not found:
        raise ConfigurationError(f"--options {name} takes one number or more")
    return list(dict.fromkeys(found))
