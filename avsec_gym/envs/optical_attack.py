"""What attackers with light have in common: a validator that must not notice."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.envs.notice import MEASURES
from avsec_gym.envs.sensor_attack import SensorAttackEnv
from avsec_gym.envs.sensor_attack_features import SIZE
from avsec_gym.geometry import Floats

_ALARM, _QUIET = (255, 70, 70), (120, 230, 120)


class OpticalAttackEnv(SensorAttackEnv):
    """Episodes of an attacker who succeeds where a drive becomes unsafe and nobody notices why."""

    known_size = SIZE + 1 + len(MEASURES)

    def known(self) -> Floats:
        """The features; then whether the last query was noticed, and its `MEASURES`.

        Before the first query, these are those without an attack.
        """
        notice = self._look.notice
        return np.concatenate([super().known(), [notice.alarm], notice.shares])

    def picture(self) -> NDArray[np.uint8] | None:
        """What the car saw and did, with what the validator said."""
        picture = super().picture()
        if picture is None:
            return None
        import cv2

        notice = self._look.notice
        shares = zip(MEASURES, notice.shares, strict=True)
        text = ", ".join(f"{name.replace('_', ' ')} {share:.3f}" for name, share in shares)
        text = f"{'noticed' if notice.alarm else 'not noticed'}: {text}"
        font, colour = cv2.FONT_HERSHEY_SIMPLEX, _ALARM if notice.alarm else _QUIET
        (width, height), below = cv2.getTextSize(text, font, 0.7, 2)
        picture[: height + below + 10, : width + 16] = 20
        cv2.putText(picture, text, (8, height + 6), font, 0.7, colour, 2, cv2.LINE_AA)
        return picture

    def _info(self, facts: dict[str, float], success: bool) -> dict[str, Any]:
        return {**super()._info(facts, success), **self._look.notice.facts}
