package org.hgros;

import java.time.Duration;
import java.time.Instant;
import java.util.function.LongToIntFunction;

/**
 * The transforms of a session, by the names of frames: those it sets, which other sessions get, and those it receives.
 */
public final class Transforms implements AutoCloseable {
  private final Handle handle;
  @SuppressWarnings("unused") // Not forgotten while its transforms are used.
  private final Session session;

  Transforms(Session session) {
    this.session = session;
    long[] opened = new long[1];
    session.handle.call(owner -> HgrosC.hgros_transforms_open(owner, opened));
    handle = new Handle("object for transforms", opened[0], HgrosC::hgros_transforms_close).closeWith(this);
  }

  /**
   * Sends what still waits. Throws {@link Code#WOULD_DEADLOCK} inside a callback of the session: then they stay open.
   */
  @Override
  public void close() {
    handle.close();
  }

  /** Sets and sends the pose of a child frame in its parent at the pose's stamp. */
  public void set(String parent, String child, Transform pose) {
    between(parent, child, transforms -> HgrosC.hgros_transforms_set(transforms, parent, child, toC(pose)));
  }

  /** The same for a pose that does not move: sessions that join later get it, too. */
  public void setStatic(String parent, String child, Transform pose) {
    between(parent, child, transforms -> HgrosC.hgros_transforms_set_static(transforms, parent, child, toC(pose)));
  }

  /** The transform from a source frame to a target at the latest time that all edges between them have. */
  public Transform lookup(String target, String source) {
    Structs.Transform found = new Structs.Transform();
    between(target, source, transforms -> HgrosC.hgros_transforms_lookup(transforms, target, source, found));
    return fromC(found);
  }

  /** The same at a time. */
  public Transform lookup(String target, String source, Instant time) {
    Structs.Transform found = new Structs.Transform();
    between(target, source,
        transforms -> HgrosC.hgros_transforms_lookup_at(transforms, target, source, nanos(time), found));
    return fromC(found);
  }

  /** The same, but waits until it is there. {@link Code#TIMED_OUT} has a sentence why it is not. */
  public Transform await(String target, String source, Instant time, Duration timeout) throws InterruptedException {
    Structs.Transform found = new Structs.Transform();
    checkNames(target, source);
    HgrosC.check(Waits.inSlices(timeout, slice -> handle.status(
        transforms -> HgrosC.hgros_transforms_wait(transforms, target, source, nanos(time), slice, found))));
    return fromC(found);
  }

  private static void checkNames(String one, String other) {
    Texts.checked("The name of a frame", one);
    Texts.checked("The name of a frame", other);
  }

  /** Calls the library for two frames. */
  private void between(String one, String other, LongToIntFunction call) {
    checkNames(one, other);
    handle.call(call);
  }

  private static long nanos(Instant time) {
    return Math.addExact(Math.multiplyExact(time.getEpochSecond(), 1_000_000_000L), time.getNano());
  }

  private static Structs.Transform toC(Transform pose) {
    Structs.Transform chosen = new Structs.Transform();
    chosen.translation = new double[] {pose.x(), pose.y(), pose.z()};
    chosen.rotation = new double[] {pose.qx(), pose.qy(), pose.qz(), pose.qw()};
    chosen.stamp_ns = nanos(pose.stamp());
    return chosen;
  }

  private static Transform fromC(Structs.Transform found) {
    double[] p = found.translation;
    double[] q = found.rotation;
    return new Transform(p[0], p[1], p[2], q[0], q[1], q[2], q[3], Instant.ofEpochSecond(0, found.stamp_ns));
  }
}
