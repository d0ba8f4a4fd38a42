import com.google.protobuf.ByteString;
import foxglove.LogOuterClass.Log;
import foxglove.PointCloudOuterClass.PointCloud;
import foxglove.PoseInFrameOuterClass.PoseInFrame;
import java.io.BufferedReader;
import java.io.IOException;
import java.io.InputStreamReader;
import java.time.Duration;
import java.util.concurrent.BlockingQueue;
import java.util.concurrent.LinkedBlockingQueue;
import java.util.concurrent.TimeUnit;
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
      case "bulk-publish" -> bulkPublish(name, Integer.parseInt(value));
      case "bulk-subscribe" -> bulkSubscribe(name, Integer.parseInt(value));
      case "serve" -> serve(name);
      case "call" -> call(name, value);
      case "misfit" -> misfit(name);
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

  private void publish(String channel, int count) throws InterruptedException {
    try (Publisher<Log> publisher = session.advertise(channel, LOG)) {
      session.waitForSubscribers(channel, 1, PATIENCE);
      int sent = 0;
      while (sent < count && !input.waits(0)) {
        try {
          publisher.publish(text(sent + 1), SLICE);
        } catch (HgrosException e) {
          if (e.code() == Code.TIMED_OUT) {
            continue;
          }
          throw e;
        }
        if (++sent == 1) {
          say("publishing");
        }
      }
      say("published " + sent);
      input.await();
    }
  }

  private void subscribe(String channel, int count) throws InterruptedException {
    int received = 0;
    String first = "";
    String last = "";
    try (Subscription<Log> queue = session.subscribe(channel, LOG, LOSSLESS)) {
      while (received < count && !input.waits(0)) {
        Log log = queue.next(SLICE);
        if (log == null) {
          continue;
        }
        last = log.getMessage();
        if (++received == 1) {
          first = last;
          say("receiving " + last);
        }
        if (first.equals("1") && !last.equals(Integer.toString(received))) {
          throw new IllegalStateException("\"" + last + "\" came, not " + received + ".");
        }
      }
      say("received " + received + " " + last);
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
      PointCloud cloud = queue.next(PATIENCE);
      if (cloud == null || !cloud.getData().equals(pattern(size))) { // Which compares all bytes.
        throw new IllegalStateException("No cloud came in time, or one with other bytes.");
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

  /** The lines of standard input, which a thread reads. */
  private static final class Input {
    private static final String END = "\n"; // No line has it.

    private final BlockingQueue<String> lines = new LinkedBlockingQueue<>();
    private String next;

    Input() {
      Thread reader = new Thread(() -> {
        try {
          BufferedReader input = new BufferedReader(new InputStreamReader(System.in));
          for (String line; (line = input.readLine()) != null; ) {
            lines.add(line);
          }
        } catch (IOException e) {
          System.err.println(e);
        }
        lines.add(END);
      });
      reader.setDaemon(true);
      reader.start();
    }

    /** Whether there is a next line, or the end, in time. */
    boolean waits(long milliseconds) throws InterruptedException {
      if (next == null) {
        next = lines.poll(milliseconds, TimeUnit.MILLISECONDS);
      }
      return next != null;
    }

    void await() throws InterruptedException {
      waits(Long.MAX_VALUE);
    }

    /** The next line; null at the end. */
    String take() throws InterruptedException {
      await();
      if (next.equals(END)) {
        return null;
      }
      String line = next;
      next = null;
      return line;
    }
  }
}
