package org.hgros;

import java.time.Duration;
import java.util.function.LongToIntFunction;

/** Times of waits, and waits of the library that an interrupt ends. */
final class Waits {
  /** The library has no way to cut such a wait short except for the end of the session. */
  private static final long SLICE_NS = 50_000_000;

  /** About 146 years: sums with the time of now do not overflow. */
  private static final Duration LONGEST = Duration.ofNanos(Long.MAX_VALUE / 2);

  private Waits() {}

  static long nanos(Duration timeout) {
    if (timeout.isNegative()) {
      return 0;
    }
    return timeout.compareTo(LONGEST) > 0 ? LONGEST.toNanos() : timeout.toNanos();
  }

  /** Waits in slices. The status after the last one is the caller's. */
  static int inSlices(Duration timeout, LongToIntFunction wait) throws InterruptedException {
    long most = nanos(timeout);
    long least = Math.min(most, 1); // With 0 the library would not wait, and say why it cannot.
    long end = System.nanoTime() + most;
    while (true) {
      if (Thread.interrupted()) {
        throw new InterruptedException();
      }
      long left = Math.max(least, end - System.nanoTime());
      int status = wait.applyAsInt(Math.min(left, SLICE_NS));
      if (status != Code.TIMED_OUT.status || left <= SLICE_NS) {
        return status;
      }
    }
  }
}
