package org.hgros;

import java.lang.ref.Cleaner;
import java.util.function.LongToIntFunction;

/** A handle of the library that may be closed while other threads use it: the last one out frees it. */
final class Handle implements Runnable {
  private static final Cleaner CLEANER = Cleaner.create();

  private final String what;
  private final long pointer;
  private final LongToIntFunction free;
  private Cleaner.Cleanable net;
  private int users;
  private boolean closed;
  private boolean freed;

  /** `free` returns the status of the library, which refuses to free some handles inside callbacks. */
  Handle(String what, long pointer, LongToIntFunction free) {
    this.what = what;
    this.pointer = pointer;
    this.free = free;
  }

  /** Closes the handle when nobody can reach `owner` any more. */
  Handle closeWith(Object owner) {
    net = CLEANER.register(owner, this);
    return this;
  }

  /** The pointer, valid until leave(). */
  synchronized long enter() {
    if (closed) {
      throw new HgrosException(Code.CLOSED, "The " + what + " is closed.");
    }
    users++;
    return pointer;
  }

  void leave() {
    synchronized (this) {
      users--;
      if (!closed || users > 0) {
        return;
      }
    }
    try {
      free();
    } catch (HgrosException e) {
      // It stays open, and is closed later.
    }
  }

  /** Calls the library with the pointer. */
  void call(LongToIntFunction call) {
    HgrosC.check(status(call));
  }

  /** The same for a status that is not always a failure. */
  int status(LongToIntFunction call) {
    long entered = enter();
    try {
      return call.applyAsInt(entered);
    } finally {
      leave();
    }
  }

  /** May be called several times. If the library refuses, the handle stays open. */
  void close() {
    synchronized (this) {
      if (closed) {
        return;
      }
      closed = true;
      if (users > 0) {
        return;
      }
    }
    free();
    if (net != null) {
      net.clean();
    }
  }

  private void free() {
    try {
      HgrosC.check(free.applyAsInt(pointer));
    } catch (HgrosException e) {
      synchronized (this) {
        closed = false;
      }
      throw e;
    }
    synchronized (this) {
      freed = true;
      notifyAll();
    }
  }

  /** Waits until those that used the closed handle are out, and it is freed. */
  synchronized void awaitFreed() {
    boolean interrupted = false;
    while (!freed) {
      try {
        wait();
      } catch (InterruptedException e) {
        interrupted = true;
      }
    }
    if (interrupted) {
      Thread.currentThread().interrupt();
    }
  }

  /** The net: called by the cleaner. */
  @Override
  public void run() {
    close();
  }
}
