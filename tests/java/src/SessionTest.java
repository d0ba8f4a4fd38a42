import com.google.protobuf.StringValue;
import java.lang.reflect.Method;
import java.nio.file.Path;
import java.time.Instant;
import java.util.List;
import java.util.concurrent.ArrayBlockingQueue;
import java.util.concurrent.BlockingQueue;
import java.util.concurrent.LinkedBlockingQueue;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.atomic.AtomicBoolean;
import org.hgros.Code;
import org.hgros.Encoding;
import org.hgros.LogLevel;
import org.hgros.ParamInfo;
import org.hgros.Params;
import org.hgros.Peer;
import org.hgros.PeerEvent;
import org.hgros.Publisher;
import org.hgros.Schema;
import org.hgros.PublishOptions;
import org.hgros.ServeOptions;
import org.hgros.Session;
import org.hgros.SessionOptions;
import org.hgros.SubscribeOptions;
import org.hgros.Transform;
import org.hgros.Transforms;
import org.hgros.Watch;

final class SessionTest {
  private SessionTest() {}

  public static void errorsAreSentences() throws Exception {
    String sentence = Expect.fails(Code.CONFIG_ERROR, () -> Session.open("sesion: {}"));
    Expect.holds(sentence.contains("sesion"), sentence);
    sentence = Expect.fails(Code.CONFIG_ERROR,
        () -> Session.openFiles(List.of(Path.of("/no/such.yaml")), new SessionOptions()));
    Expect.holds(sentence.contains("/no/such.yaml"), sentence);
    try (Session session = Expect.session("robot7")) {
      Expect.equal(session.name(), "robot7");
      sentence = Expect.fails(Code.ERROR, () -> session.advertise("", Expect.TEXT));
      Expect.holds(sentence.endsWith("."), sentence);
    }
  }

  public static void theLogGoesToTheProgram() throws Exception {
    BlockingQueue<String> lines = new LinkedBlockingQueue<>();
    try (Session session = Expect.session(new SessionOptions().name("logger").log((level, line) -> {
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
      AtomicBoolean seen = new AtomicBoolean();
      Expect.eventually("the other session is seen and goes", () -> {
        boolean there = !here.peers().isEmpty() || here.channels().stream().anyMatch(
            channel -> channel.name().equals("words") && channel.publishers() == 1);
        seen.compareAndSet(false, there);
        if (seen.get()) {
          System.gc();
        }
        return seen.get() && !there;
      });
    }
  }

  private static Object of(String type, int number) throws ReflectiveOperationException {
    Method of = Class.forName("org.hgros." + type).getDeclaredMethod("of", int.class);
    of.setAccessible(true);
    return of.invoke(null, number);
  }

  public static void numbersOfANewerLibraryAreNoFailure() throws Exception {
    Expect.equal(of("LogLevel", 2), LogLevel.WARNING);
    Expect.equal(of("LogLevel", 4), LogLevel.ERROR);
    Expect.equal(of("LogLevel", -1), LogLevel.DEBUG);
    Expect.equal(of("PeerEvent", 3), PeerEvent.SERVED_TWICE);
    Expect.equal(of("PeerEvent", 4), PeerEvent.UNKNOWN);
    Expect.equal(of("PeerEvent", -1), PeerEvent.UNKNOWN);
    Expect.equal(of("Encoding", 9), Encoding.UNKNOWN);
    Expect.equal(of("Code", 99), Code.UNKNOWN);
  }

  public static void textsThatCWouldCutAreRefused() throws Exception {
    String cut = "words\0more";
    try (Session session = Expect.session("texts"); Params params = session.params();
        Transforms transforms = session.transforms()) {
      Transform pose = Transform.at(1, 2, 3);
      List<Expect.Action> uses = List.of(
          () -> Session.open("{}\0"),
          () -> Session.open("", new SessionOptions().name(cut)),
          () -> session.log(LogLevel.INFO, cut),
          () -> session.advertise(cut, Expect.TEXT),
          () -> session.subscribe(cut, Expect.TEXT),
          () -> session.subscribe("words", Expect.TEXT, new SubscribeOptions().name(cut)),
          () -> session.waitForSubscribers(cut, 1, Expect.PATIENCE),
          () -> session.waitForPublishers(cut, 1, Expect.PATIENCE),
          () -> session.serve(cut, Expect.TEXT, Expect.TEXT, request -> request),
          () -> session.call(cut, Expect.TEXT, Expect.TEXT, Expect.PATIENCE),
          () -> session.callLater(cut, Expect.TEXT, Expect.TEXT, Expect.PATIENCE),
          () -> session.paramsOf(cut, Expect.PATIENCE),
          () -> Schema.known(cut),
          () -> Schema.raw(cut, Encoding.CUSTOM, 0),
          () -> params.declare(cut, 1, new ParamInfo()),
          () -> params.declare("a", cut, new ParamInfo()),
          () -> params.declare("a", "b", new ParamInfo().description(cut)),
          () -> params.declare("a", "b", new ParamInfo().unit(cut)),
          () -> params.declare("a", "b", new ParamInfo().choices("b", cut)),
          () -> params.set("a", cut),
          () -> params.set(cut, 1),
          () -> params.setYaml("a", cut),
          () -> params.getYaml(cut),
          () -> params.remove(cut),
          () -> params.onChange(cut, (path, yaml) -> { }),
          () -> transforms.setStatic("map", cut, pose),
          () -> transforms.set(cut, "base", pose),
          () -> transforms.lookup("map", cut),
          () -> transforms.await("map", cut, Instant.EPOCH, Expect.PATIENCE));
      Expect.refused(uses, "U+0000", "\\0");
      session.serve("fails", Expect.TEXT, Expect.TEXT, request -> {
        throw new IllegalStateException("a\0b");
      });
      String sentence = Expect.fails(Code.HANDLER_FAILED,
          () -> session.call("fails", Expect.TEXT, Expect.TEXT, Expect.PATIENCE));
      Expect.equal(sentence, "a b");
    }
  }

  public static void textsWithHalfASurrogatePairAreRefused() throws Exception {
    String half = "words \ud83d";
    try (Session session = Expect.session("texts")) {
      Expect.refused(List.of(
          () -> session.log(LogLevel.INFO, half),
          () -> session.advertise(half, Expect.TEXT),
          () -> session.paramsOf(half, Expect.PATIENCE)), "surrogate");
    }
  }

  public static void negativeNumbersOfMessagesAreRefused() throws Exception {
    Expect.refused(List.of(
        () -> new SubscribeOptions().keepLast(-1),
        () -> new SubscribeOptions().keepAll(-1),
        () -> new SubscribeOptions().keepAllBytes(-1),
        () -> new PublishOptions().latched(-1),
        () -> new ServeOptions().mostWaiting(-1)), "is -1");
  }
}
