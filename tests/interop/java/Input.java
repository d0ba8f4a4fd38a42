import java.io.BufferedReader;
import java.io.IOException;
import java.io.InputStreamReader;
import java.util.concurrent.BlockingQueue;
import java.util.concurrent.LinkedBlockingQueue;
import java.util.concurrent.TimeUnit;

/** The lines of standard input, which a thread reads. */
final class Input {
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
