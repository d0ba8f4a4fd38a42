package org.hgros;

import java.util.concurrent.Executor;
import java.util.concurrent.Executors;
import java.util.concurrent.atomic.AtomicLong;

/** Daemon threads for callbacks that have no executor of their own. */
final class Workers {
  private static final AtomicLong NUMBER = new AtomicLong();

  static final Executor ANY = Executors.newCachedThreadPool(task -> {
    Thread thread = new Thread(task, "hgros-callback-" + NUMBER.incrementAndGet());
    thread.setDaemon(true);
    return thread;
  });

  private Workers() {}
}
