"""DSGN's presets: the published networks for cars, and those for a CPU."""

from __future__ import annotations

from dataclasses import replace

from avsec_gym.perception.detectors.dsgn.configuration import (
    CAR,
    FEATURES,
    DepthScale,
    DsgnConfiguration,
    GridAxis,
    WorldGrid,
)
from avsec_gym.perception.nn.pyramid_pooling import FeatureConfiguration

_DEFAULT = DsgnConfiguration()
_24G = replace(
    _DEFAULT,
    features=replace(FEATURES, first=16, semantic=None),
    volume_begins_with_hourglass=True,
    costs_in_grid=False,
    grid_kernel=1,
    grid_hourglass=False,
)
_12G = replace(
    _24G,
    features=replace(
        _24G.features,
        first=8,
        stages=((16, 3), (32, 4), (64, 6), (128, 3)),
        matching=(128, 32),
    ),
)
_SMALL = DsgnConfiguration(
    # Columns tell disparity, and with it depth; rows do not.
    input_size=(128, 768),
    padded_size=(128, 768),
    features=FeatureConfiguration(
        first=16,
        stages=((16, 1), (32, 2), (48, 1), (48, 1)),
        joined=(2, 3, 4),
        windows=((32, 48), (16, 24), (8, 12), (4, 6)),
        pooled=8,
        aligned_corners=True,
        matching=(32, 32),
        semantic=(32, 16),
        groups=4,
    ),
    groups=4,
    # In the logarithm: 0.3 m apart at 4 m, 1.4 m at 20 m; 0.1 to 1.3 pixels of the features.
    planes=DepthScale(48.0, 3.2, 40, power=0),
    bins=DepthScale(48.0, 3.2, 40, power=0),
    sampled=DepthScale(48.0, 3.2, 2, power=0),
    full_depth=False,
    # Learns to match sooner than joined features: in a trial of one seed, the depth loss after
    # 160 pairs was 1.7 against 4.5.
    correlation_groups=8,
    volume_channels=8,
    volume_begins_with_hourglass=True,
    volume_residual=True,
    cost_kernel=1,
    grid=WorldGrid(GridAxis(-20.0, 20.0, 100), GridAxis(3.0, -1.0, 5), GridAxis(48.0, 3.2, 112)),
    exact_pixels=True,
    grid_channels=16,
    grid_kernel=1,
    grid_hourglass=False,
    pooled_heights=1,
    view_channels=48,
    anchors=(CAR,),
)
_SMALL_WITHOUT_PYRAMID = replace(_SMALL, features=replace(_SMALL.features, pyramid=False))
PRESETS = {
    "default": _DEFAULT,
    "24g": _24G,
    "12g": _12G,
    "small": _SMALL,
    "small_without_pyramid": _SMALL_WITHOUT_PYRAMID,
}
