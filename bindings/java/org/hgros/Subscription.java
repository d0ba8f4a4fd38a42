package org.hgros;

import com.google.protobuf.Message;
import java.time.Duration;
import java.util.concurrent.Executor;
import java.util.function.Consumer;

/** A queue of received protobuf messages of one type. Messages of another type are counted, not delivered. */
public final class Subscription<T extends Message> implements AutoCloseable {
  private final RawSubscription raw;
  private final T prototype;

  Subscription(Session session, String channel, T prototype, SubscribeOptions options) {
    this.prototype = prototype;
    raw = new RawSubscription(session, channel, Schema.of(prototype.getDescriptorForType()), options);
  }

  /** Waits for the oldest message. Throws {@link Code#CLOSED} once the subscription or its session has ended. */
  public T next() throws InterruptedException {
    return read(raw.takePointer(Long.MAX_VALUE / 2));
  }

  /** The same, but null if none came in time. With a time of zero it does not wait. */
  public T next(Duration timeout) throws InterruptedException {
    long message = raw.takePointer(Waits.nanos(timeout));
    return message == 0 ? null : read(message);
  }

  private T read(long message) {
    try {
      return ReceivedMessage.parse(message, prototype);
    } finally {
      HgrosC.hgros_message_free(message);
    }
  }

  /** The same as {@link #onMessage(Executor, Consumer)}, on a thread of this package. */
  public Subscription<T> onMessage(Consumer<T> callback) {
    return onMessage(Workers.ANY, callback);
  }

  /**
   * As {@link RawSubscription#onMessage(Executor, Consumer)}, with messages that are read, and belong to the callback.
   */
  public Subscription<T> onMessage(Executor executor, Consumer<T> callback) {
    raw.onPointer(executor, message -> callback.accept(read(message)));
    return this;
  }

  /** The queue itself: takes messages with their bytes and {@link ReceivedMessage#info}. */
  public RawSubscription raw() {
    return raw;
  }

  /** Counts since the subscription began. */
  public SubscriptionStats stats() {
    return raw.stats();
  }

  /** Ends the subscription and wakes those that wait. Outside callbacks it waits for the running one. */
  @Override
  public void close() {
    raw.close();
  }
}
