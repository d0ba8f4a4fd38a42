import foxglove.LogOuterClass.Log;
import org.hgros.Publisher;
import org.hgros.RawSubscription;
import org.hgros.ReceivedMessage;
import org.hgros.Session;
import org.hgros.SubscribeOptions;
import org.hgros.Subscription;

/** In a process of its own, which no other test has made larger. */
final class MemoryTest {
  private MemoryTest() {}

  public static void memoryDoesNotGrow() throws Exception {
    try (Session session = Expect.session("steady")) {
      Subscription<Log> queue = session.subscribe("log", Log.getDefaultInstance(), new SubscribeOptions().keepAll(10));
      RawSubscription leases = session.subscribeRaw("log", new SubscribeOptions().keepAll(10));
      Publisher<Log> publisher = session.advertise("log", Log.getDefaultInstance());
      Log message = Log.newBuilder().setMessage("x".repeat(1000)).build();
      long before = 0;
      for (int i = 0; i < 120_000; i++) {
        if (i == 20_000) {
          before = residentKilobytes();
        }
        publisher.publish(message, Expect.PATIENCE);
        Expect.equal(queue.next(Expect.PATIENCE).getMessage().length(), 1000);
        try (ReceivedMessage taken = leases.take(Expect.PATIENCE)) {
          Expect.holds(taken.data().remaining() > 1000, i);
        }
      }
      long growth = residentKilobytes() - before;
      Expect.holds(growth < 48 * 1024, "the process has grown by " + growth + " KB");
      Expect.equal(ReceivedMessage.leases(), 0L);
    }
  }

  private static long residentKilobytes() throws Exception {
    System.gc();
    String line = java.nio.file.Files.readAllLines(java.nio.file.Path.of("/proc/self/status")).stream()
        .filter(entry -> entry.startsWith("VmRSS:")).findFirst().orElseThrow();
    return Long.parseLong(line.replaceAll("[^0-9]", ""));
  }
}
