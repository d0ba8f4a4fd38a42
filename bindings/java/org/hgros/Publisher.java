package org.hgros;

import com.google.protobuf.CodedOutputStream;
import com.google.protobuf.Message;
import java.io.IOException;
import java.io.UncheckedIOException;
import java.nio.ByteBuffer;
import java.time.Duration;

/** Publishes protobuf messages of one type on one channel. Large ones are written where receivers on this host read. */
public final class Publisher<T extends Message> implements AutoCloseable {
  /** From here on copying costs more than three further calls of the library. */
  private static final int IN_PLACE_BYTES = 32 * 1024;

  private final RawPublisher raw;
  private final String typeName;

  Publisher(Session session, String channel, T prototype, PublishOptions options) {
    typeName = prototype.getDescriptorForType().getFullName();
    raw = new RawPublisher(session, channel, Schema.of(prototype.getDescriptorForType()), options);
  }

  /** Publishes a message. Never waits: {@link Code#FULL} says that a lossless subscriber has no room. */
  public void publish(T message) {
    int size = checkedSize(message);
    if (size < IN_PLACE_BYTES) {
      raw.publish(message.toByteArray());
    } else {
      raw.publishInPlace(size, buffer -> write(message, buffer));
    }
  }

  /** Publishes a message, and waits while a lossless subscriber has no room. */
  public void publish(T message, Duration timeout) throws InterruptedException {
    int size = checkedSize(message);
    if (size < IN_PLACE_BYTES) {
      raw.publish(message.toByteArray(), timeout);
    } else {
      raw.publishInPlace(size, buffer -> write(message, buffer), timeout);
    }
  }

  /** The compiler does not see the types of dynamic messages. */
  private int checkedSize(T message) {
    String given = message.getDescriptorForType().getFullName();
    if (!given.equals(typeName)) {
      throw new HgrosException(Code.TYPE_MISMATCH, "The channel has the type \"" + typeName + "\", but a \"" + given
          + "\" was given to publish.");
    }
    return message.getSerializedSize();
  }

  private static void write(Message message, ByteBuffer buffer) {
    try {
      CodedOutputStream stream = CodedOutputStream.newInstance(buffer);
      message.writeTo(stream);
      stream.flush();
    } catch (IOException e) {
      throw new UncheckedIOException(e);
    }
  }

  @Override
  public void close() {
    raw.close();
  }
}
