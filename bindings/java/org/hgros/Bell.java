package org.hgros;

import com.sun.jna.Memory;
import java.util.concurrent.locks.Condition;
import java.util.concurrent.locks.ReentrantLock;

/** Rung when a queue may have messages, or has ended, once for each time that it was armed. */
final class Bell {
  final int descriptor;
  final Memory event; // What epoll knows of it. Never changes.
  private final Runnable armed;
  private final ReentrantLock lock = new ReentrantLock();
  private final Condition rung = lock.newCondition();
  private long rings;
  private Runnable onRing;

  /** `arm` makes sure that the descriptor is open, and calls {@link QueuePoller#arm}. */
  Bell(int descriptor, Memory event, Runnable arm) {
    this.descriptor = descriptor;
    this.event = event;
    this.armed = arm;
  }

  /** Throws {@link Code#CLOSED} if the queue is closed. */
  void arm() {
    armed.run();
  }

  /** Waits for a ring. A queue that has messages already rings at once. False if the time came first. */
  boolean await(long nanos) throws InterruptedException {
    lock.lockInterruptibly();
    try {
      long before = rings;
      arm();
      while (rings == before) {
        if (nanos <= 0) {
          return false;
        }
        nanos = rung.awaitNanos(nanos);
      }
      return true;
    } finally {
      lock.unlock();
    }
  }

  /** Runs `task`, which must not take long, at each ring. */
  void onRing(Runnable task) {
    lock.lock();
    try {
      onRing = task;
    } finally {
      lock.unlock();
    }
  }

  /** Wakes those who wait, and runs no task any more. */
  void end() {
    onRing(null);
    ring();
  }

  void ring() {
    Runnable task;
    lock.lock();
    try {
      rings++;
      rung.signalAll();
      task = onRing;
    } finally {
      lock.unlock();
    }
    if (task != null) {
      task.run();
    }
  }
}
