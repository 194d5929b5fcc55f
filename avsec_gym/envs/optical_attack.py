"""What attackers with light have in common: a validator that must not detect them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.envs.sensor_attack import SensorAttackEnv
from avsec_gym.envs.sensor_attack_features import SIZE
from avsec_gym.envs.validator_report import MEASURES
from avsec_gym.geometry import Floats

_ALARM, _QUIET = (255, 70, 70), (120, 230, 120)


class OpticalAttackEnv(SensorAttackEnv):
    """Episodes of an attacker who succeeds where the car's plan becomes unsafe without an alarm."""

    known_size = SIZE + 1 + len(MEASURES)

    def known(self) -> Floats:
        """The features; then the validator's report: the alarm and its `MEASURES`.

        Before the first query, the report is the one without an attack.
        """
        report = self._look.report
        return np.concatenate([super().known(), [report.alarm], report.shares])

    def picture(self) -> NDArray[np.uint8] | None:
        """What the car saw and did, with the validator's report."""
        picture = super().picture()
        if picture is None:
            return None
        import cv2

        report = self._look.report
        shares = zip(MEASURES, report.shares, strict=True)
        text = ", ".join(f"{name.replace('_', ' ')} {share:.3f}" for name, share in shares)
        text = f"{'alarm' if report.alarm else 'no alarm'}: {text}"
        font, colour = cv2.FONT_HERSHEY_SIMPLEX, _ALARM if report.alarm else _QUIET
        (width, height), below = cv2.getTextSize(text, font, 0.7, 2)
        picture[: height + below + 10, : width + 16] = 20
        cv2.putText(picture, text, (8, height + 6), font, 0.7, colour, 2, cv2.LINE_AA)
        return picture

    def _info(self, facts: dict[str, float], success: bool) -> dict[str, Any]:
        return {**super()._info(facts, success), **self._look.report.facts}
