"""A scenario by hand: two vehicles scan the faces of a third, all in CARLA's left-handed frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np

CAR = {"location": [20.0, 6.0, 0.1], "center": [0.0, 0.0, 0.7], "extent": [2.2, 0.9, 0.7]}
YAW, SPEED = 30.0, 18.0
SENSORS = {"641": [0.0, 0.0, 1.9, 0.0, 10.0, 0.0], "650": [35.0, 20.0, 2.4, 2.0, -140.0, -3.0]}


def published_matrix(pose: list[float]) -> np.ndarray:
    """The matrix of a pose as CARLA and OpenCOOD write it out, entry by entry."""
    x, y, z, roll, yaw, pitch = pose
    cr, cy, cp = np.cos(np.radians([roll, yaw, pitch]))
    sr, sy, sp = np.sin(np.radians([roll, yaw, pitch]))
    return np.array(
        [
            [cp * cy, cy * sp * sr - sy * cr, -cy * sp * cr - sy * sr, x],
            [cp * sy, sy * sp * sr + cy * cr, -sy * sp * cr + cy * sr, y],
            [sp, -cp * sr, cp * cr, z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def faces_of_car() -> np.ndarray:
    """Points just inside the faces of the car in CARLA's world, shape (M, 3)."""
    random = np.random.default_rng(0)
    points = random.uniform(-0.99, 0.99, (60, 3))
    points[np.arange(60), random.integers(3, size=60)] = random.choice([-0.99, 0.99], 60)
    turned = published_matrix([*np.add(CAR["location"], CAR["center"]), 0.0, YAW, 0.0])
    return points * CAR["extent"] @ turned[:3, :3].T + turned[:3, 3]


def write_sample(root: Path, instants: tuple[str, ...] = ("00069", "00071")) -> Path:
    """A folder of one scenario; returns the scenario."""
    scenario = root / "2021_08_22_21_41_24"
    for name, pose in SENSORS.items():
        (scenario / name).mkdir(parents=True)
        to_sensor = np.linalg.inv(published_matrix(pose))
        seen = faces_of_car() @ to_sensor[:3, :3].T + to_sensor[:3, 3]
        for instant in instants:
            write_yaml(scenario / name / f"{instant}.yaml", pose)
            write_ascii_pcd(scenario / name / f"{instant}.pcd", seen)
            (scenario / name / f"{instant}_camera0.png").write_bytes(b"not looked at")
    (scenario / "data_protocol.yaml").write_text("world:\n  sync_mode: true\n")
    return scenario


def write_yaml(path: Path, pose: list[float]) -> None:
    """As PyYAML dumps it, with a camera and with a class of another program."""

    def numbers(key: str, values: list[float], indent: str = "") -> str:
        return f"{indent}{key}:\n" + "".join(f"{indent}- {value}\n" for value in values)

    moved = [pose[0] + 1.0, *pose[1:]]
    path.write_text(
        "camera0:\n  intrinsic:\n  - - 335.6\n    - 0.0\n"
        + "ego_speed: 36.0\n"
        + numbers("lidar_pose", pose)
        + "plan: !!python/object/apply:os.system ['true']\n"
        + numbers("predicted_ego_pos", moved)
        + numbers("true_ego_pos", pose)
        + "vehicles:\n  1732:\n"
        + numbers("angle", [0.0, YAW, 0.0], "    ")
        + "".join(numbers(key, values, "    ") for key, values in CAR.items())
        + f"    speed: {SPEED}\n"
    )


def write_ascii_pcd(path: Path, points: np.ndarray, red: int = 128) -> None:
    """As Open3D writes it: the reflectance is the red of a packed colour, printed as a float."""
    colour = np.array([red << 16], np.uint32).view(np.float32)[0]
    rows = "".join(f"{x:.10g} {y:.10g} {z:.10g} {colour:.10g}\n" for x, y, z in points)
    path.write_text(pcd_header(len(points), "ascii") + rows)


def pcd_header(points: int, data: str) -> str:
    """Of points with a packed colour."""
    return (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb\n"
        f"SIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH {points}\nHEIGHT 1\n"
        f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA {data}\n"
    )
