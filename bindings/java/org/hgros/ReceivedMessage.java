package org.hgros;

import com.google.protobuf.DynamicMessage;
import com.google.protobuf.InvalidProtocolBufferException;
import com.google.protobuf.Message;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.time.Instant;

/**
 * A received message. Its bytes are a lease on the sender's memory: close it soon. One that is forgotten is closed when
 * neither it nor its bytes can be reached.
 */
public final class ReceivedMessage implements AutoCloseable {
  private final Handle handle;
  private final ByteBuffer bytes; // All views of it keep it reachable, and so the lease.

  /** Takes a message over. */
  ReceivedMessage(long message) {
    bytes = bytesOf(message);
    handle = new Handle("message", message, pointer -> {
      HgrosC.hgros_message_free(pointer);
      return 0;
    }).closeWith(bytes);
  }

  static ByteBuffer bytesOf(long message) {
    long[] size = new long[1];
    long data = HgrosC.hgros_message_data(message, size);
    return HgrosC.memoryAt(data, size[0]);
  }

  /** Reads a message as one of the type of `prototype`, which it has. */
  static <T extends Message> T parse(long message, T prototype) {
    try {
      @SuppressWarnings("unchecked") // The parser of a message makes messages of the same class.
      T parsed = (T) prototype.getParserForType().parseFrom(bytesOf(message));
      return parsed;
    } catch (InvalidProtocolBufferException e) {
      throw new HgrosException(Code.NOT_WRITABLE,
          "The message cannot be read as " + prototype.getDescriptorForType().getFullName() + ": " + e.getMessage());
    }
  }

  /** Ends the lease. Nobody may read the bytes of {@link #data} after it: the sender writes its next messages there. */
  @Override
  public void close() {
    handle.close();
  }

  /** The message's bytes, without a copy, in native byte order; valid until the message is closed. */
  public ByteBuffer data() {
    handle.enter();
    try {
      return bytes.asReadOnlyBuffer().order(ByteOrder.nativeOrder());
    } finally {
      handle.leave();
    }
  }

  /** A copy of the type that came with the channel. */
  public Schema schema() {
    long message = handle.enter();
    try {
      return Schema.copyOf(HgrosC.hgros_message_schema(message));
    } finally {
      handle.leave();
    }
  }

  /** Reads the message as one of the type of `prototype`, such as {@code Log.getDefaultInstance()}. */
  public <T extends Message> T read(T prototype) {
    long message = handle.enter();
    try {
      String came = HgrosC.textAt(HgrosC.hgros_schema_type_name(HgrosC.hgros_message_schema(message)));
      String wanted = prototype.getDescriptorForType().getFullName();
      if (!came.equals(wanted)) {
        throw new HgrosException(Code.TYPE_MISMATCH,
            "The message is a \"" + came + "\", but is read as \"" + wanted + "\".");
      }
      return parse(message, prototype);
    } finally {
      handle.leave();
    }
  }

  /** Reads the message with the type that came with the channel, without generated code. */
  public DynamicMessage decode() {
    long message = handle.enter();
    try {
      return parse(message,
          DynamicMessage.getDefaultInstance(Schema.descriptorOf(HgrosC.hgros_message_schema(message))));
    } finally {
      handle.leave();
    }
  }

  /** Where the message comes from. */
  public MessageInfo info() {
    Structs.MessageInfo info = new Structs.MessageInfo();
    handle.call(message -> HgrosC.hgros_message_get_info(message, info));
    return new MessageInfo(info.remote != 0, info.publisher, info.sequence, info.key, Instant.ofEpochSecond(0,
        info.publish_time_ns));
  }

  /** A lease of its own on the same bytes: keeps what a callback gets beyond its end. */
  public ReceivedMessage keep() {
    long[] kept = new long[1];
    handle.call(message -> HgrosC.hgros_message_keep(message, kept));
    return new ReceivedMessage(kept[0]);
  }

  /** The number of messages of this process that are not yet closed. */
  public static long leases() {
    return HgrosC.hgros_message_leases();
  }
}
