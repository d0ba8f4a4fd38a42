package org.hgros;

import java.util.concurrent.atomic.AtomicLong;
import java.util.function.Function;

/** Something that is watched until it or its session is closed. */
public final class Watch implements AutoCloseable {
  private final Session session;
  private final Handle handle;
  private final AtomicLong failed;
  @SuppressWarnings("unused") // Not forgotten while it is watched.
  private final Object owner;

  /** Runs a call of the program's function, and reports what it throws. */
  @FunctionalInterface
  interface Runner {
    void run(Runnable call);
  }

  @FunctionalInterface
  interface Opening {
    int open(long user, long[] watch);
  }

  private Watch(Session session, Object owner, Handle handle, AtomicLong failed) {
    this.session = session;
    this.owner = owner;
    this.handle = handle;
    this.failed = failed;
  }

  /** `owner` lives as long as the watch. */
  static Watch open(Session session, Object owner, String what, Function<Runner, Object> target, Opening opening) {
    AtomicLong failed = new AtomicLong();
    Runner runner = call -> {
      try {
        call.run();
      } catch (Throwable e) {
        failed.incrementAndGet();
        session.report(what + " failed", e);
      }
    };
    long[] opened = new long[1];
    long user = Callbacks.keep(target.apply(runner));
    try {
      HgrosC.check(opening.open(user, opened));
    } catch (HgrosException e) {
      Callbacks.forget(user); // If the owner is closed, the library never had it.
      throw e;
    }
    return session.keep(new Watch(session, owner, new Handle("watch", opened[0], pointer -> {
      HgrosC.hgros_watch_close(pointer);
      return 0;
    }), failed));
  }

  /** The number of calls that threw. The session's log says what: ten, then fewer and fewer. */
  public long failed() {
    return failed.get();
  }

  /** No call comes after it. Outside callbacks it waits for the running one. */
  @Override
  public void close() {
    session.forget(this);
    handle.close();
  }
}
