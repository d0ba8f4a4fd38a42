import com.google.protobuf.ByteString;
import com.google.protobuf.Message;
import foxglove.LogOuterClass.Log;
import foxglove.PointCloudOuterClass.PointCloud;
import foxglove.PoseInFrameOuterClass.PoseInFrame;
import java.time.Duration;
import java.util.concurrent.atomic.AtomicLong;
import org.hgros.Code;
import org.hgros.HgrosException;
import org.hgros.PublishOptions;
import org.hgros.Publisher;
import org.hgros.Service;
import org.hgros.Session;
import org.hgros.SubscribeOptions;
import org.hgros.Subscription;

/** One side of a talk between two languages: ROLE [ARGUMENT...], or talk for roles from standard input. */
final class Peer {
  private static final Duration PATIENCE = Duration.ofSeconds(30);
  private static final Duration SLICE = Duration.ofMillis(100);
  private static final Log LOG = Log.getDefaultInstance();
  private static final PointCloud CLOUD = PointCloud.getDefaultInstance();
  private static final SubscribeOptions LOSSLESS = new SubscribeOptions().keepAll(100);

  private final Session session;
  private final Input input = new Input();

  private Peer(Session session) {
    this.session = session;
  }

  public static void main(String[] words) throws InterruptedException {
    try (Session session = Session.open(System.getenv().getOrDefault("HGROS_INTEROP_YAML", ""))) {
      new Peer(session).run(words);
    } catch (RuntimeException e) {
      System.err.println(e);
      System.exit(1);
    }
  }

  private void run(String[] words) throws InterruptedException {
    String name = words.length > 1 ? words[1] : "";
    String value = words.length > 2 ? words[2] : "";
    switch (words[0]) {
      case "talk" -> talk();
      case "publish" -> publish(name, Integer.parseInt(value));
      case "subscribe" -> subscribe(name, Integer.parseInt(value));
      case "latch" -> latch(name, value);
      case "late" -> late(name);
      case "bulk-publish" -> bulkPublish(name, Integer.parseInt(value));
      case "bulk-subscribe" -> bulkSubscribe(name, Integer.parseInt(value));
      case "serve" -> serve(name);
      case "call" -> call(name, value);
      case "misfit" -> misfit(name);
      case "stream" -> stream(name);
      case "follow" -> follow(name);
      default -> throw new IllegalArgumentException("There is no role " + words[0] + ".");
    }
  }

  private void talk() throws InterruptedException {
    say("ready");
    for (String line; (line = input.take()) != null; ) {
      if (!line.isBlank()) {
        run(line.strip().split(" +"));
      }
    }
  }

  private static void say(String line) {
    System.out.println(line);
    System.out.flush();
  }

  private static Log text(Object message) {
    return Log.newBuilder().setMessage(message.toString()).build();
  }

  private static <T extends Message> T received(Subscription<T> queue) throws InterruptedException {
    T message = queue.next(PATIENCE);
    if (message == null) {
      throw new IllegalStateException("No message came in time.");
    }
    return message;
  }

  private void publish(String channel, int count) throws InterruptedException {
    try (Publisher<Log> publisher = session.advertise(channel, LOG)) {
      session.waitForSubscribers(channel, 1, PATIENCE);
      for (int i = 1; i <= count; i++) {
        publisher.publish(text(i), PATIENCE);
      }
      say("published " + count);
      input.await();
    }
  }

  private void subscribe(String channel, int count) throws InterruptedException {
    try (Subscription<Log> queue = session.subscribe(channel, LOG, LOSSLESS)) {
      say("subscribed");
      for (int i = 1; i <= count; i++) {
        String message = received(queue).getMessage();
        if (!message.equals(Integer.toString(i))) {
          throw new IllegalStateException("\"" + message + "\" came, not " + i + ".");
        }
      }
      say("received " + count);
    }
  }

  private void latch(String channel, String message) throws InterruptedException {
    try (Publisher<Log> publisher = session.advertise(channel, LOG, new PublishOptions().latched(2))) {
      for (String one : new String[] {"old", message, "new"}) {
        publisher.publish(text(one));
      }
      say("latched");
      input.await();
    }
  }

  private void late(String channel) throws InterruptedException {
    try (Subscription<Log> queue = session.subscribe(channel, LOG)) {
      say("late " + received(queue).getMessage());
    }
  }

  private static ByteString pattern(int size) {
    byte[] bytes = new byte[size];
    for (int i = 0; i < size; i++) {
      bytes[i] = (byte) (i * 7 + 3);
    }
    return ByteString.copyFrom(bytes);
  }

  private void bulkPublish(String channel, int size) throws InterruptedException {
    try (Publisher<PointCloud> publisher = session.advertise(channel, CLOUD)) { // Writes large messages in place.
      session.waitForSubscribers(channel, 1, PATIENCE);
      publisher.publish(PointCloud.newBuilder().setPointStride(1).setData(pattern(size)).build(), PATIENCE);
      say("published " + size);
      input.await();
    }
  }

  private void bulkSubscribe(String channel, int size) throws InterruptedException {
    try (Subscription<PointCloud> queue = session.subscribe(channel, CLOUD, LOSSLESS)) {
      say("subscribed");
      if (!received(queue).getData().equals(pattern(size))) { // Which compares all bytes.
        throw new IllegalStateException("The cloud has other bytes.");
      }
      say("received " + size);
    }
  }

  private void serve(String name) throws InterruptedException {
    try (Service service = session.serve(name, LOG, LOG, request -> {
      if (request.getMessage().equals("fail")) {
        throw new IllegalArgumentException("asked to fail");
      }
      return text("re: " + request.getMessage());
    })) {
      say("serving");
      input.await();
    }
  }

  private void call(String name, String message) throws InterruptedException {
    long end = System.nanoTime() + PATIENCE.toNanos();
    while (true) {
      try {
        say("answer " + session.call(name, text(message), LOG, PATIENCE).getMessage());
        return;
      } catch (HgrosException e) {
        if (e.code() != Code.NO_SERVER || System.nanoTime() > end) {
          say("failed " + e.getMessage());
          return;
        }
      }
      if (input.waits(10)) {
        throw new IllegalStateException("Nobody serves " + name + ".");
      }
    }
  }

  private void misfit(String channel) throws InterruptedException {
    try (Subscription<PoseInFrame> queue = session.subscribe(channel, PoseInFrame.getDefaultInstance())) {
      say("subscribed");
      input.await();
    }
  }

  private void stream(String channel) throws InterruptedException {
    try (Publisher<Log> publisher = session.advertise(channel, LOG)) {
      session.waitForSubscribers(channel, 1, PATIENCE);
      long sent = 0;
      while (!input.waits(0)) {
        try {
          publisher.publish(text(sent + 1), SLICE);
        } catch (HgrosException e) {
          if (e.code() == Code.TIMED_OUT) {
            continue;
          }
          throw e;
        }
        if (++sent == 1) {
          say("streaming");
        }
      }
      say("streamed " + sent);
    }
  }

  private void follow(String channel) throws InterruptedException {
    AtomicLong count = new AtomicLong();
    try (Subscription<Log> queue = session.subscribe(channel, LOG, LOSSLESS)) {
      queue.onMessage(message -> {
        if (count.incrementAndGet() == 1) {
          say("following");
        }
      });
      input.await();
    }
    say("followed " + count);
  }
}
