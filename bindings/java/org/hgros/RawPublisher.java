package org.hgros;

import java.nio.ByteBuffer;
import java.time.Duration;
import java.util.function.Consumer;

/** Publishes bytes of one type on one channel. */
public final class RawPublisher implements AutoCloseable {
  private final Handle handle;
  @SuppressWarnings("unused") // Not forgotten while its publisher is used.
  private final Session session;

  RawPublisher(Session session, String channel, Schema schema, PublishOptions options) {
    this.session = session;
    Texts.checked("The name of the channel", channel);
    Structs.PublishOptions chosen = new Structs.PublishOptions();
    chosen.latched = options.latched;
    long[] opened = new long[1];
    session.handle.call(owner -> schema.handle.status(
        type -> HgrosC.hgros_publisher_open(owner, channel, type, chosen, opened)));
    handle = new Handle("publisher of channel \"" + channel + "\"", opened[0], pointer -> {
      HgrosC.hgros_publisher_close(pointer);
      return 0;
    }).closeWith(this);
  }

  /** Publishes a copy of the bytes. Never waits: {@link Code#FULL} says that a lossless subscriber has no room. */
  public void publish(byte[] data) {
    handle.call(publisher -> HgrosC.hgros_publish(publisher, data, data.length));
  }

  /** Publishes a copy of the bytes, and waits while a lossless subscriber has no room. */
  public void publish(byte[] data, Duration timeout) throws InterruptedException {
    HgrosC.check(Waits.inSlices(timeout,
        slice -> handle.status(publisher -> HgrosC.hgros_publish_wait(publisher, data, data.length, slice))));
  }

  /**
   * Publishes a message of `size` bytes, which `fill` writes where receivers on this host read, without a copy. The
   * buffer, in native byte order, has arbitrary values at first, and may not be used after `fill` has returned. Never
   * waits.
   */
  public void publishInPlace(int size, Consumer<ByteBuffer> fill) {
    long loan = loan(size, fill);
    try {
      HgrosC.check(HgrosC.hgros_loan_publish(loan, 0));
    } finally {
      HgrosC.hgros_loan_free(loan);
    }
  }

  /** The same, and waits while a lossless subscriber has no room. */
  public void publishInPlace(int size, Consumer<ByteBuffer> fill, Duration timeout) throws InterruptedException {
    long loan = loan(size, fill);
    try {
      HgrosC.check(Waits.inSlices(timeout, slice -> HgrosC.hgros_loan_publish(loan, slice)));
    } finally {
      HgrosC.hgros_loan_free(loan);
    }
  }

  /** A loan that is filled. */
  private long loan(int size, Consumer<ByteBuffer> fill) {
    if (size < 0) {
      throw new HgrosException(Code.INVALID_ARGUMENT,
          "The size of a message is " + size + ", but must not be negative.");
    }
    long[] opened = new long[1];
    handle.call(publisher -> HgrosC.hgros_loan_open(publisher, size, opened));
    try {
      fill.accept(HgrosC.memoryAt(HgrosC.hgros_loan_data(opened[0], null), size));
    } catch (Throwable e) {
      HgrosC.hgros_loan_free(opened[0]);
      throw e;
    }
    return opened[0];
  }

  @Override
  public void close() {
    handle.close();
  }
}
