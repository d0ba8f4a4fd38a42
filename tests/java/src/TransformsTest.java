import java.time.Duration;
import java.time.Instant;
import java.util.concurrent.CompletableFuture;
import org.hgros.Code;
import org.hgros.Session;
import org.hgros.Transform;
import org.hgros.Transforms;

final class TransformsTest {
  private TransformsTest() {}

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
