import com.google.protobuf.Descriptors.Descriptor;
import com.google.protobuf.DynamicMessage;
import com.google.protobuf.StringValue;
import com.google.protobuf.Struct;
import com.google.protobuf.Value;
import foxglove.LogOuterClass.Log;
import java.nio.ByteBuffer;
import java.nio.ReadOnlyBufferException;
import java.time.Instant;
import org.hgros.Code;
import org.hgros.Encoding;
import org.hgros.HgrosException;
import org.hgros.MessageInfo;
import org.hgros.PublishOptions;
import org.hgros.Publisher;
import org.hgros.RawPublisher;
import org.hgros.RawSubscription;
import org.hgros.ReceivedMessage;
import org.hgros.Schema;
import org.hgros.Session;
import org.hgros.SubscribeOptions;
import org.hgros.Subscription;

final class MessagesTest {
  private MessagesTest() {}

  public static void typedMessagesGoFromSessionToSession() throws Exception {
    try (Session from = Expect.session("from"); Session to = Expect.session("to");
        Subscription<StringValue> queue = to.subscribe("words", Expect.TEXT, new SubscribeOptions().keepAll(10));
        Publisher<StringValue> publisher = from.advertise("words", Expect.TEXT)) {
      from.waitForSubscribers("words", 1, Expect.PATIENCE);
      publisher.publish(StringValue.of("last"));
      try (ReceivedMessage message = queue.raw().take(Expect.PATIENCE)) {
        MessageInfo info = message.info();
        Expect.holds(info.remote() && info.publisher() == from.id() && info.publishTime().isAfter(Instant.EPOCH), info);
        Expect.equal(message.read(Expect.TEXT).getValue(), "last");
      }
    }
  }

  public static void theTypeComesWithTheChannel() throws Exception {
    try (Session from = Expect.session("from"); Session to = Expect.session("to")) {
      Struct value = Struct.newBuilder().putFields("wheels", Value.newBuilder().setNumberValue(4).build()).build();
      from.advertise("things", Struct.getDefaultInstance(), new PublishOptions().latched(1)).publish(value);
      RawSubscription queue = to.subscribeRaw("things", new SubscribeOptions());
      try (ReceivedMessage message = queue.take(Expect.PATIENCE)) { // The latched one.
        DynamicMessage decoded = message.decode();
        Expect.equal(Struct.parseFrom(decoded.toByteString()), value);
        Expect.equal(message.schema().typeName(), "google.protobuf.Struct");
        String sentence = Expect.fails(Code.TYPE_MISMATCH, () -> message.read(Expect.TEXT));
        Expect.holds(sentence.contains("google.protobuf.Struct"), sentence);
        // The type that came is good for publishing, too.
        DynamicMessage empty = DynamicMessage.getDefaultInstance(message.schema().descriptor());
        Publisher<DynamicMessage> back = to.advertise("back", empty, new PublishOptions().latched(1));
        back.publish(decoded);
        Expect.equal(from.subscribe("back", Struct.getDefaultInstance()).next(Expect.PATIENCE), value);
        DynamicMessage other = DynamicMessage.getDefaultInstance(StringValue.getDescriptor());
        Expect.fails(Code.TYPE_MISMATCH, () -> back.publish(other));
      }
    }
  }

  public static void schemasOfDescriptorsAreThoseOfTheLibrary() throws Exception {
    Schema known = Schema.known("foxglove.Log");
    for (Descriptor descriptor : new Descriptor[] {Log.getDescriptor(), known.descriptor()}) {
      Schema made = Schema.of(descriptor);
      Expect.equal(made.typeName(), "foxglove.Log");
      Expect.equal(made.encoding(), Encoding.PROTOBUF);
      Expect.holds(made.fingerprint() != 0 && made.fingerprint() == known.fingerprint(), made.fingerprint());
    }
    Expect.fails(Code.NOT_FOUND, () -> Schema.known("no.Such"));
    Descriptor nested = Log.getDescriptor().getFile().getDependencies().get(0).getMessageTypes().get(0);
    Expect.equal(Schema.of(nested).descriptor().getFullName(), "google.protobuf.Timestamp");
  }

  public static void rawBytesAreLeases() throws Exception {
    try (Session session = Expect.session("raw")) {
      RawSubscription queue = session.subscribeRaw("bytes", new SubscribeOptions());
      RawPublisher publisher =
          session.advertiseRaw("bytes", Schema.raw("my.bytes", Encoding.CUSTOM, 0), new PublishOptions());
      long before = ReceivedMessage.leases();
      publisher.publish(new byte[] {1, 2, 3});
      publisher.publish(new byte[0]);
      ReceivedMessage first = queue.take(Expect.PATIENCE);
      ReceivedMessage second = queue.take(Expect.PATIENCE);
      Expect.equal(first.data(), ByteBuffer.wrap(new byte[] {1, 2, 3}));
      Expect.equal(second.data().remaining(), 0);
      Expect.equal(ReceivedMessage.leases(), before + 2);
      Expect.thrown(ReadOnlyBufferException.class, () -> first.data().put(0, (byte) 9));
      Expect.fails(Code.NOT_FOUND, first::decode);
      ReceivedMessage kept = first.keep();
      first.close();
      first.close();
      Expect.fails(Code.CLOSED, first::data);
      Expect.equal(kept.data().get(2), (byte) 3);
      kept.close();
      Expect.equal(ReceivedMessage.leases(), before + 1);
      second.close();
    }
  }

  public static void aForgottenMessageIsClosedWhenItsBytesAreForgotten() throws Exception {
    try (Session session = Expect.session("raw")) {
      RawSubscription queue = session.subscribeRaw("bytes", new SubscribeOptions());
      session.advertiseRaw("bytes", Schema.raw("my.bytes", Encoding.CUSTOM, 0), new PublishOptions())
          .publish(new byte[] {7});
      ByteBuffer view = queue.take(Expect.PATIENCE).data().slice();
      for (int i = 0; i < 5; i++) {
        System.gc();
        Expect.equal(ReceivedMessage.leases(), 1L);
      }
      Expect.equal(view.get(0), (byte) 7);
      view = null;
      Expect.eventually("the lease is given back", () -> {
        System.gc();
        return ReceivedMessage.leases() == 0;
      });
    }
  }

  public static void largeRawMessagesAreWrittenInPlace() throws Exception {
    byte[] bytes = new byte[4 << 20];
    for (int i = 0; i < bytes.length; i++) {
      bytes[i] = (byte) (i * 7 + 3);
    }
    try (Session from = Expect.session("from"); Session to = Expect.session("to")) {
      RawPublisher raw = from.advertiseRaw("raw", Schema.raw("my.bytes", Encoding.CUSTOM, 0), new PublishOptions());
      RawSubscription taken = to.subscribeRaw("raw", new SubscribeOptions().keepAll(1));
      from.waitForSubscribers("raw", 1, Expect.PATIENCE);
      raw.publishInPlace(bytes.length, buffer -> buffer.put(bytes));
      try (ReceivedMessage message = taken.take(Expect.PATIENCE)) {
        Expect.equal(message.data(), ByteBuffer.wrap(bytes));
      }
      Expect.thrown(java.nio.BufferOverflowException.class,
          () -> raw.publishInPlace(10, buffer -> buffer.put(bytes), Expect.PATIENCE));
      Expect.equal(taken.take(java.time.Duration.ofMillis(1)), null);
    }
  }

  public static void whatIsClosedSaysSo() throws Exception {
    Session session = Expect.session("short");
    Publisher<StringValue> publisher = session.advertise("words", Expect.TEXT);
    Subscription<StringValue> queue = session.subscribe("words", Expect.TEXT);
    Expect.fails(Code.TYPE_MISMATCH, () -> session.advertise("words", Struct.getDefaultInstance()));
    publisher.close();
    publisher.close();
    String sentence = Expect.fails(Code.CLOSED, () -> publisher.publish(Expect.TEXT));
    Expect.equal(sentence, "The publisher of channel \"words\" is closed.");
    queue.close();
    Expect.fails(Code.CLOSED, queue::next);
    Expect.fails(Code.CLOSED, queue::stats);
    Publisher<StringValue> late = session.advertise("words", Expect.TEXT);
    session.close();
    session.close();
    Expect.fails(Code.CLOSED, () -> late.publish(Expect.TEXT));
    late.close();
    Expect.fails(Code.CLOSED, () -> session.advertise("words", Expect.TEXT));
    HgrosException printed = Expect.thrown(HgrosException.class, session::id);
    Expect.equal(printed.toString(), "hgros: closed: The session is closed.");
  }
}
