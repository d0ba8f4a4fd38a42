import com.google.protobuf.StringValue;
import java.lang.ref.WeakReference;
import java.time.Duration;
import java.util.Objects;
import java.util.concurrent.Callable;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.ExecutionException;
import java.util.concurrent.Future;
import java.util.concurrent.TimeUnit;
import org.hgros.Code;
import org.hgros.HgrosException;
import org.hgros.Session;
import org.hgros.SessionOptions;

/** What the tests share. */
final class Expect {
  static final Duration PATIENCE = Duration.ofSeconds(45);
  static final StringValue TEXT = StringValue.getDefaultInstance();

  private Expect() {}

  /** The action of a test that may throw. */
  interface Action {
    void run() throws Exception;
  }

  static Session session(String name) {
    return Session.open("", new SessionOptions().name(name));
  }

  static void equal(Object actual, Object expected) {
    if (!Objects.equals(actual, expected)) {
      throw new AssertionError(actual + " instead of " + expected);
    }
  }

  static void holds(boolean condition, Object about) {
    if (!condition) {
      throw new AssertionError(about);
    }
  }

  /** The sentence of the failure. */
  static String fails(Code code, Action action) throws Exception {
    try {
      action.run();
    } catch (HgrosException e) {
      if (e.code() == code) {
        return e.getMessage();
      }
      throw e;
    }
    throw new AssertionError("it did not fail with " + code);
  }

  /** Waits for a latch also in callbacks. */
  static void passes(CountDownLatch latch) {
    try {
      holds(latch.await(PATIENCE.toSeconds(), TimeUnit.SECONDS), latch.getCount() + " did not come");
    } catch (InterruptedException e) {
      throw new IllegalStateException(e);
    }
  }

  static void collected(WeakReference<?> garbage) throws Exception {
    eventually("garbage is collected", () -> {
      System.gc();
      return garbage.get() == null;
    });
  }

  /** The failure with which a future ends. */
  static void ends(Future<?> future, Code code) throws Exception {
    try {
      future.get(PATIENCE.toSeconds(), TimeUnit.SECONDS);
    } catch (ExecutionException e) {
      equal(((HgrosException) e.getCause()).code(), code);
      return;
    }
    throw new AssertionError("it did not end with " + code);
  }

  static void eventually(String what, Callable<Boolean> condition) throws Exception {
    long end = System.nanoTime() + PATIENCE.toNanos();
    while (!condition.call()) {
      holds(System.nanoTime() < end, what + " did not hold in time");
      Thread.sleep(2);
    }
  }
}
