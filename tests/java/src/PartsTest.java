import java.lang.ref.WeakReference;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.time.Instant;
import java.util.List;
import java.util.concurrent.ArrayBlockingQueue;
import java.util.concurrent.BlockingQueue;
import java.util.concurrent.CompletableFuture;
import org.hgros.Code;
import org.hgros.HgrosException;
import org.hgros.ParamInfo;
import org.hgros.Params;
import org.hgros.Session;
import org.hgros.Transform;
import org.hgros.Transforms;
import org.hgros.Watch;

/** Parameters and transforms. */
final class PartsTest {
  private PartsTest() {}

  public static void parametersAreDeclaredSetAndWatched() throws Exception {
    Path file = Files.createTempFile("params", ".yaml");
    try (Session session = Expect.session("robot")) {
      Files.writeString(file, "wheel: {radius: 0.25}\n");
      Params params = session.params(file);
      params.declare("wheel.radius", 0.1, new ParamInfo().unit("m").most(1));
      params.declare("wheel.count", 4, new ParamInfo());
      params.declare("name", "it's: \"mine\"\n\u00e4", new ParamInfo().description("Whose it is."));
      params.declare("gains", new double[] {1, 2.5}, new ParamInfo());
      params.declare("on", true, new ParamInfo());
      params.declare("mode", "fast", new ParamInfo().choices("fast", "slow"));
      Expect.equal(params.getNumber("wheel.radius"), 0.25);
      Expect.equal(params.getInteger("wheel.count"), 4L);
      Expect.equal(params.getText("name"), "it's: \"mine\"\n\u00e4");
      Expect.equal(params.getBool("on"), true);
      Expect.equal(params.getYaml("gains"), "[1.0, 2.5]");
      BlockingQueue<String> changes = new ArrayBlockingQueue<>(10);
      Watch watch = params.onChange("wheel", (path, yaml) -> {
        changes.add(path + "=" + yaml);
        throw new IllegalStateException("nobody minds");
      });
      params.set("wheel.radius", 0.5);
      Expect.equal(changes.take(), "wheel.radius=0.5");
      Expect.equal(watch.failed(), 1L);
      Expect.fails(Code.REFUSED, () -> params.set("wheel.radius", 2.0));
      Expect.fails(Code.REFUSED, () -> params.set("mode", "idle"));
      Expect.fails(Code.REFUSED, () -> params.getNumber("no.such"));
      params.remove("wheel.radius");
      Expect.equal(params.getNumber("wheel.radius"), 0.1);
      params.save();
      watch.close();
      changes.clear();
      params.set("wheel.count", 3);
      Expect.equal(List.copyOf(changes), List.of());
      params.close();
      Expect.fails(Code.CLOSED, () -> params.getBool("on"));
    } finally {
      Files.delete(file);
    }
  }

  public static void parametersLiveWhileTheyAreWatchedAndAnotherSessionSetsThem() throws Exception {
    BlockingQueue<String> changes = new ArrayBlockingQueue<>(100);
    try (Session robot = Expect.session("robot"); Session tool = Expect.session("tool")) {
      watch(robot, changes);
      Expect.collected(new WeakReference<>(new Object()));
      try (Params theirs = tool.paramsOf("robot", Expect.PATIENCE)) {
        Expect.eventually("the parameter can be set", () -> {
          try {
            theirs.set("speed", 7);
            return true;
          } catch (HgrosException e) {
            return false;
          }
        });
        Expect.equal(changes.take(), "speed=7");
        Expect.equal(theirs.getInteger("speed"), 7L);
      }
    }
  }

  /** Nobody but the watch knows the parameters. */
  private static void watch(Session robot, BlockingQueue<String> changes) {
    Params params = robot.params();
    params.declare("speed", 1, new ParamInfo());
    params.onChange("speed", (path, yaml) -> changes.add(path + "=" + yaml));
  }

  public static void transformsAreFoundByName() throws Exception {
    try (Session robot = Expect.session("robot"); Session tool = Expect.session("tool");
        Transforms sent = robot.transforms(); Transforms seen = tool.transforms()) {
      sent.setStatic("map", "base", Transform.at(1, 2, 3));
      Expect.equal(seen.await("map", "base", Instant.EPOCH, Expect.PATIENCE), Transform.at(1, 2, 3));
      Instant now = Instant.now();
      sent.set("base", "arm", Transform.at(0, 0, 1, now));
      Expect.equal(sent.lookup("map", "arm", now), Transform.at(1, 2, 4, now));
      Expect.equal(sent.lookup("map", "arm"), Transform.at(1, 2, 4, now));
      Expect.fails(Code.UNKNOWN_FRAME, () -> sent.lookup("map", "moon"));
      String sentence = Expect.fails(Code.TIMED_OUT,
          () -> seen.await("map", "moon", Instant.EPOCH, Duration.ofMillis(20)));
      Expect.holds(sentence.contains("moon"), sentence);
      CompletableFuture<Transform> waiting = CompletableFuture.supplyAsync(() -> {
        try {
          return seen.await("map", "moon", Instant.EPOCH, Expect.PATIENCE);
        } catch (InterruptedException e) {
          throw new IllegalStateException(e);
        }
      });
      tool.end();
      Expect.ends(waiting, Code.CLOSED);
    }
  }
}
