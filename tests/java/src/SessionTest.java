import com.google.protobuf.StringValue;
import java.nio.file.Path;
import java.util.List;
import java.util.concurrent.ArrayBlockingQueue;
import java.util.concurrent.BlockingQueue;
import java.util.concurrent.LinkedBlockingQueue;
import java.util.concurrent.TimeUnit;
import org.hgros.Code;
import org.hgros.LogLevel;
import org.hgros.Peer;
import org.hgros.PeerEvent;
import org.hgros.Publisher;
import org.hgros.Session;
import org.hgros.SessionOptions;
import org.hgros.Watch;

final class SessionTest {
  private SessionTest() {}

  public static void errorsAreSentences() throws Exception {
    String sentence = Expect.fails(Code.CONFIG_ERROR, () -> Session.open("sesion: {}"));
    Expect.holds(sentence.contains("sesion"), sentence);
    sentence = Expect.fails(Code.CONFIG_ERROR,
        () -> Session.openFiles(List.of(Path.of("/no/such.yaml")), new SessionOptions()));
    Expect.holds(sentence.contains("/no/such.yaml"), sentence);
    try (Session session = Session.open("", new SessionOptions().name("robot7"))) {
      Expect.equal(session.name(), "robot7");
      sentence = Expect.fails(Code.ERROR, () -> session.advertise("", Expect.TEXT));
      Expect.holds(sentence.endsWith("."), sentence);
    }
  }

  public static void theLogGoesToTheProgram() throws Exception {
    BlockingQueue<String> lines = new LinkedBlockingQueue<>();
    try (Session session = Session.open("", new SessionOptions().name("logger").log((level, line) -> {
      lines.add(level + " " + line);
      throw new IllegalStateException("a log that fails harms nobody");
    }))) {
      session.log(LogLevel.WARNING, "It rains in K\u00f6ln.");
      for (String line = ""; !line.equals("WARNING It rains in K\u00f6ln."); ) {
        line = lines.poll(Expect.PATIENCE.toSeconds(), TimeUnit.SECONDS);
        Expect.holds(line != null, "the line did not reach the log");
      }
    }
  }

  public static void peersAndChannelsAreSeen() throws Exception {
    try (Session here = Expect.session("here")) {
      BlockingQueue<Peer> came = new ArrayBlockingQueue<>(10);
      Watch watch = here.onPeer((event, peer, channel, reason) -> {
        if (event == PeerEvent.CAME) {
          came.add(peer);
          throw new IllegalStateException("nobody minds");
        }
      });
      here.subscribe("words", Expect.TEXT);
      try (Session there = Expect.session("there");
          Publisher<StringValue> used = there.advertise("words", Expect.TEXT)) {
        there.waitForSubscribers("words", 1, Expect.PATIENCE);
        here.waitForPublishers("words", 1, Expect.PATIENCE);
        Peer peer = came.poll(Expect.PATIENCE.toSeconds(), TimeUnit.SECONDS);
        Expect.equal(peer.id(), there.id());
        Expect.equal(peer.pid(), ProcessHandle.current().pid());
        Expect.equal(here.peers().get(0).id(), there.id());
        Expect.eventually("the channel is known", () -> here.channels().stream().anyMatch(
            channel -> channel.name().equals("words") && channel.typeName().equals("google.protobuf.StringValue")
                && channel.publishers() == 1));
        used.publish(Expect.TEXT);
        Expect.eventually("what the listener threw is counted", () -> watch.failed() == 1);
      }
    }
  }

  public static void sessionsThatAreForgottenAreClosed() throws Exception {
    try (Session here = Expect.session("here")) {
      Expect.session("forgotten").advertise("words", Expect.TEXT);
      Expect.eventually("the other session is seen and goes", new java.util.concurrent.Callable<>() {
        private boolean seen;

        @Override
        public Boolean call() {
          boolean there = !here.peers().isEmpty() || here.channels().stream().anyMatch(
              channel -> channel.name().equals("words") && channel.publishers() == 1);
          seen |= there;
          if (seen) {
            System.gc();
          }
          return seen && !there;
        }
      });
    }
  }
}
