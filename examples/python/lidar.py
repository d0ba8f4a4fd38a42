"""lidar.py: publishes clouds of a wavy floor, ten per second."""

import numpy as np

import hgros
from foxglove.PackedElementField_pb2 import PackedElementField
from foxglove.PointCloud_pb2 import PointCloud

SIDE = 200  # points, 5 cm apart
POINT_BYTES = 12


def main() -> None:
    across, along = np.meshgrid(np.arange(SIDE) * 0.05, np.arange(SIDE) * 0.05)
    with hgros.Session() as robot:
        robot.transforms.send_static("map", "lidar", np.eye(4))
        for number, tick in enumerate(robot.rate(0.1)):
            # The cloud is written where the subscribers will read it.
            with robot.loan("points", PointCloud, SIDE * SIDE * POINT_BYTES) as cloud:
                cloud.timestamp.FromNanoseconds(tick.now_ns)
                cloud.frame_id = "lidar"
                cloud.point_stride = POINT_BYTES
                for at, name in enumerate("xyz"):
                    cloud.fields.add(name=name, offset=4 * at, type=PackedElementField.FLOAT32)
                points = hgros.points(cloud)
                points["x"] = across.ravel()
                points["y"] = along.ravel()
                points["z"] = np.sin(across + 0.1 * number).ravel() * np.cos(along).ravel()


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
