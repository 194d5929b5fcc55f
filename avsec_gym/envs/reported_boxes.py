"""What an agent reports, in the place of a detector of the car."""

from __future__ import annotations

from avsec_gym.attacks.attack import LEFT, RIGHT
from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame


class Reported:
    """The agent in the detector's place: it finds what its last action reports.

    Args:
        sensors: 2 for the two cameras, 3 for the LiDAR, too.
    """

    name = "agent"

    def __init__(self, sensors: int) -> None:
        self.boxes, self._sensors = Boxes3D.empty(), sensors

    def look(self, frame: SensorFrame) -> None:
        """Ask the frame for all that the agent is shown.

        Raises:
            Untrusted: A sensor is compromised, and nothing takes its place.
        """
        frame.image(LEFT)
        frame.image(RIGHT)
        if self._sensors > 2:
            _ = frame.points

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """The reported boxes."""
        self.look(frame)
        return self.boxes
