"""height_image.py: draws the clouds on channel `points` from above. The brighter a pixel, the higher its points."""

import numpy as np

import hgros
from foxglove.PointCloud_pb2 import PointCloud
from foxglove.RawImage_pb2 import RawImage


def main() -> None:
    with hgros.Session() as robot:
        image = robot.advertise("height", RawImage)
        cell = robot.params.declare("cell", 0.1, "Size of a pixel", unit="m", least=0.01, most=1.0)

        @robot.params.on_change("cell")
        def on_change(paths: list[str]) -> None:
            nonlocal cell
            cell = robot.params["cell"]

        @robot.subscribe("points", PointCloud, queue=hgros.KeepLast(1))
        def on_cloud(cloud: PointCloud, info: hgros.MessageInfo) -> None:
            points = hgros.points(cloud)  # No copy: the memory where the cloud arrived.
            column = (points["x"] / cell + 1e-3).astype(int)  # A little more: some points are on the edges of pixels.
            row = (points["y"] / cell + 1e-3).astype(int)
            row, column = row - row.min(), column - column.min()
            height = np.full((row.max() + 1, column.max() + 1), -np.inf)
            np.maximum.at(height, (row, column), points["z"])
            seen = np.isfinite(height)
            low, high = height[seen].min(), height[seen].max()
            pixels = np.zeros(height.shape, np.uint8)
            pixels[seen] = 55 + 200 * (height[seen] - low) / max(high - low, 1e-6)
            image.publish(RawImage(timestamp=cloud.timestamp, frame_id=cloud.frame_id, width=pixels.shape[1],
                                   height=pixels.shape[0], encoding="mono8", step=pixels.shape[1],
                                   data=pixels.tobytes()))

        robot.spin()


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
