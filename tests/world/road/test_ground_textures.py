import numpy as np
import pytest

from avsec_gym.world.textures.ground import TEXTURES
from avsec_gym.world.textures.library import draw


@pytest.mark.parametrize("name", list(TEXTURES))
def test_ground_textures_repeat_without_a_seam(name):
    picture = draw(f"{name}/{TEXTURES[name].variants - 1}").astype(float)
    assert picture.shape == (512, 512, 3)
    for axis in (0, 1):
        turned = np.moveaxis(picture, axis, 0)
        inside = np.abs(np.diff(turned, axis=0)).mean(axis=(1, 2))
        seam = np.abs(turned[0] - turned[-1]).mean()
        # No more unlike than neighbouring rows are; joints of stones are such rows.
        assert seam <= 1.15 * np.quantile(inside, 0.995)
