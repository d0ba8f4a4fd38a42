package org.hgros;

import com.sun.jna.Memory;
import com.sun.jna.Native;
import com.sun.jna.Platform;
import com.sun.jna.Pointer;
import java.util.Map;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.atomic.AtomicLong;

/**
 * Waits with epoll for all queues of the process, on one thread, so that those who wait in Java can be interrupted and
 * hold no thread of their own.
 */
final class QueuePoller {
  private static final int ADD = 1;
  private static final int DELETE = 2;
  private static final int MODIFY = 3;
  private static final int READABLE_ONCE = 1 | 1 << 30; // EPOLLIN | EPOLLONESHOT
  private static final int CLOSE_ON_EXEC = 0x80000;
  private static final int MOST_EVENTS = 64;

  /** struct epoll_event is packed on x86-64 alone. */
  private static final int NUMBER_OFFSET = Platform.isIntel() ? 4 : 8;
  private static final int EVENT_BYTES = NUMBER_OFFSET + 8;

  private static final Map<Long, Bell> BELLS = new ConcurrentHashMap<>();
  private static final AtomicLong NUMBER = new AtomicLong();
  private static final int POLL;

  static {
    Native.register(QueuePoller.class, Platform.C_LIBRARY_NAME);
    POLL = epoll_create1(CLOSE_ON_EXEC);
    if (POLL < 0) {
      throw new HgrosException(Code.ERROR, "The system has no descriptor left to wait for queues.");
    }
    Thread thread = new Thread(QueuePoller::loop, "hgros-queues");
    thread.setDaemon(true);
    thread.start();
  }

  private QueuePoller() {}

  private static native int epoll_create1(int flags);
  private static native int epoll_ctl(int poll, int operation, int descriptor, Pointer event);
  private static native int epoll_wait(int poll, Pointer events, int most, int timeout);

  /** A bell for a queue's descriptor, until it is removed. It does not ring before it is armed. */
  static Bell add(int descriptor, Runnable arm) {
    long number = NUMBER.incrementAndGet();
    Memory event = new Memory(EVENT_BYTES);
    event.setLong(NUMBER_OFFSET, number);
    event.setInt(0, 0);
    if (epoll_ctl(POLL, ADD, descriptor, event) != 0) {
      throw new HgrosException(Code.ERROR,
          "The descriptor of a queue cannot be waited for: errno " + Native.getLastError() + ".");
    }
    event.setInt(0, READABLE_ONCE);
    Bell bell = new Bell(descriptor, event, arm);
    BELLS.put(number, bell);
    return bell;
  }

  /** The descriptor must be open. */
  static void arm(Bell bell) {
    epoll_ctl(POLL, MODIFY, bell.descriptor, bell.event);
  }

  static void remove(Bell bell) {
    epoll_ctl(POLL, DELETE, bell.descriptor, bell.event);
    BELLS.remove(bell.event.getLong(NUMBER_OFFSET));
  }

  private static void loop() {
    Memory events = new Memory((long) MOST_EVENTS * EVENT_BYTES);
    while (true) {
      int count = epoll_wait(POLL, events, MOST_EVENTS, -1); // -1 after a signal.
      for (int i = 0; i < count; i++) {
        ring(events.getLong((long) i * EVENT_BYTES + NUMBER_OFFSET));
      }
    }
  }

  /** All queues of the process depend on this thread, so what one of them throws must not end it. */
  private static void ring(long number) {
    try {
      Bell bell = BELLS.get(number);
      if (bell != null) {
        bell.ring();
      }
    } catch (Throwable e) {
      Callbacks.reportUncaught(e);
    }
  }
}
