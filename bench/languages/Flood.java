import foxglove.LaserScanOuterClass.LaserScan;
import java.util.concurrent.CompletableFuture;
import org.hgros.Session;
import org.hgros.SubscribeOptions;

/** Receives as many messages as its argument says in a callback, and prints how many came per second. */
public final class Flood {
  private int received;
  private long begin;

  private Flood() {}

  public static void main(String[] arguments) {
    new Flood().run(Integer.parseInt(arguments[0]));
  }

  private void run(int flood) {
    CompletableFuture<Double> rate = new CompletableFuture<>();
    try (Session session = Session.open()) {
      session.subscribe("flood", LaserScan.getDefaultInstance(), new SubscribeOptions().keepAll(1000))
          .onMessage(scan -> {
            if (scan.getStartAngle() != received) {
              rate.completeExceptionally(
                  new IllegalStateException("message " + scan.getStartAngle() + " came in place of " + received));
            }
            if (received++ == 0) {
              begin = System.nanoTime();
            }
            if (received == flood) {
              rate.complete(1e9 * flood / (System.nanoTime() - begin));
            }
          });
      System.out.println(Math.round(rate.join()));
    }
  }
}
