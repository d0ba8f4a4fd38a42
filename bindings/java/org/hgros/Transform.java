package org.hgros;

import java.time.Instant;

/**
 * p_target = rotation * p_source + translation, in meters. The rotation is a unit quaternion.
 *
 * @param stamp the time at which it holds; 1970 if only static transforms connect the frames
 */
public record Transform(double x, double y, double z, double qx, double qy, double qz, double qw, Instant stamp) {
  /** Without a rotation, for {@link Transforms#setStatic}. */
  public static Transform at(double x, double y, double z) {
    return at(x, y, z, Instant.EPOCH);
  }

  /** Without a rotation. */
  public static Transform at(double x, double y, double z, Instant stamp) {
    return new Transform(x, y, z, 0, 0, 0, 1, stamp);
  }
}
