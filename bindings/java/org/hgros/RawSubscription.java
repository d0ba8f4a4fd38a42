package org.hgros;

import java.time.Duration;
import java.util.concurrent.Executor;
import java.util.concurrent.atomic.AtomicLong;
import java.util.concurrent.locks.ReentrantLock;
import java.util.function.Consumer;
import java.util.function.LongConsumer;

/** A queue of received messages, as bytes. Each message goes to one that takes, or to the callback. */
public final class RawSubscription implements AutoCloseable {
  /** A callback leaves its thread to others after this many messages. */
  private static final int MOST_IN_A_ROW = 64;

  /** Whether this thread runs a callback of a subscription: it must not wait for another one, which may wait for it. */
  private static final ThreadLocal<Boolean> INSIDE = ThreadLocal.withInitial(() -> false);

  private final Session session;
  private final String channel;
  private final Handle handle;
  private final Bell bell;
  private final AtomicLong failed = new AtomicLong();
  private final ReentrantLock turn = new ReentrantLock(); // Of the callback.

  /** `schema` null: any type. */
  RawSubscription(Session session, String channel, Schema schema, SubscribeOptions options) {
    this.session = session;
    this.channel = channel;
    Structs.SubscribeOptions chosen = new Structs.SubscribeOptions();
    Texts.checked("The name of the channel", channel);
    chosen.name = Texts.checked("The name of the subscription", options.name);
    chosen.keep_last = options.keepLast;
    chosen.keep_all = options.keepAll;
    chosen.keep_all_bytes = options.keepAllBytes;
    long[] opened = new long[1];
    session.handle.call(owner -> {
      if (schema == null) {
        return HgrosC.hgros_subscribe_queue(owner, channel, chosen, opened);
      }
      return schema.handle.status(type -> {
        chosen.schema = type;
        return HgrosC.hgros_subscribe_queue(owner, channel, chosen, opened);
      });
    });
    // Neither the handle nor the bell keeps this reachable, unless there is a callback.
    Queue queue = new Queue(channel, opened[0]);
    handle = queue.handle.closeWith(this);
    bell = queue.bell;
  }

  /** A queue of the library and its bell, which live equally long. */
  private static final class Queue {
    final Handle handle;
    final Bell bell;

    Queue(String channel, long opened) {
      handle = new Handle("subscription of channel \"" + channel + "\"", opened, this::free);
      try {
        bell = QueuePoller.add(HgrosC.hgros_queue_descriptor(opened), this::arm);
      } catch (Throwable e) {
        HgrosC.hgros_subscription_close(opened);
        throw e;
      }
    }

    private int free(long pointer) {
      QueuePoller.remove(bell);
      HgrosC.hgros_subscription_close(pointer);
      bell.end(); // Those that take see that it is closed.
      return 0;
    }

    private void arm() {
      handle.status(pointer -> {
        QueuePoller.arm(bell);
        return 0;
      });
    }
  }

  /**
   * Waits for the oldest message, which the caller closes. Throws {@link Code#CLOSED} once the subscription or its
   * session has ended.
   */
  public ReceivedMessage take() throws InterruptedException {
    return new ReceivedMessage(takePointer(Long.MAX_VALUE / 2));
  }

  /** The same, but null if none came in time. With a time of zero it does not wait. */
  public ReceivedMessage take(Duration timeout) throws InterruptedException {
    long message = takePointer(Waits.nanos(timeout));
    return message == 0 ? null : new ReceivedMessage(message);
  }

  /** A message that the caller frees; 0 if none came in time. */
  long takePointer(long nanos) throws InterruptedException {
    long end = System.nanoTime() + nanos;
    while (true) {
      if (Thread.interrupted()) {
        throw new InterruptedException();
      }
      long message = tryTake();
      if (message != 0 || nanos == 0) {
        return message;
      }
      if (!bell.await(end - System.nanoTime())) {
        return tryTake();
      }
    }
  }

  /** A message that the caller frees; 0 if none waits. */
  private long tryTake() {
    long[] message = new long[1];
    int status = handle.status(queue -> HgrosC.hgros_queue_take(queue, 0, message));
    if (status != Code.TIMED_OUT.status) {
      HgrosC.check(status);
    }
    return message[0];
  }

  /** The same as {@link #onMessage(Executor, Consumer)}, on a thread of this package. */
  public RawSubscription onMessage(Consumer<ReceivedMessage> callback) {
    return onMessage(Workers.ANY, callback);
  }

  /**
   * From now on calls `callback` with each message, in order, one call at a time, in tasks of `executor`, until the
   * subscription or its session is closed, which waits for it. The message is closed when the callback returns. What it
   * throws is written into the session's log and counted. The executor must not run tasks on the thread that gives them
   * to it, which serves all queues.
   */
  public RawSubscription onMessage(Executor executor, Consumer<ReceivedMessage> callback) {
    onPointer(executor, message -> {
      try (ReceivedMessage received = new ReceivedMessage(message)) {
        callback.accept(received);
      }
    });
    return this;
  }

  /** The same with messages that the callback frees. */
  void onPointer(Executor executor, LongConsumer callback) {
    Runnable drain = () -> drain(callback);
    bell.onRing(() -> {
      try {
        executor.execute(drain);
      } catch (Throwable e) {
        session.report("The executor of channel \"" + channel + "\" takes no task, so the subscription ends", e);
        end();
      }
    });
    session.keep(this);
    bell.arm();
  }

  private void end() {
    session.forget(this);
    handle.close();
  }

  private void drain(LongConsumer callback) {
    if (!turn.tryLock()) {
      return; // The one that runs arms the bell when it is done.
    }
    boolean before = INSIDE.get();
    INSIDE.set(true);
    try {
      for (int i = 0; i < MOST_IN_A_ROW; i++) {
        long message = tryTake();
        if (message == 0) {
          break;
        }
        run(callback, message);
      }
    } catch (HgrosException e) { // The session has ended.
      end();
    } finally {
      INSIDE.set(before);
      turn.unlock();
      try {
        bell.arm();
      } catch (HgrosException e) {
        // Closed meanwhile.
      }
    }
  }

  private void run(LongConsumer callback, long message) {
    try {
      callback.accept(message);
    } catch (Throwable e) {
      failed.incrementAndGet();
      session.report("The callback of channel \"" + channel + "\" failed", e);
    }
  }

  /** Counts since the subscription began. */
  public SubscriptionStats stats() {
    Structs.SubscriptionStats stats = new Structs.SubscriptionStats();
    handle.call(queue -> HgrosC.hgros_subscription_get_stats(queue, stats));
    return new SubscriptionStats(stats.received, stats.dropped, stats.run, stats.queued, stats.mismatched,
        failed.get());
  }

  /** Ends the subscription and wakes those that take. Outside callbacks it waits for the running one. */
  @Override
  public void close() {
    end();
    bell.end();
    if (!INSIDE.get() && !Callbacks.inside()) {
      turn.lock();
      turn.unlock();
    }
  }
}
