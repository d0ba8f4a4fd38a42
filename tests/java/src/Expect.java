import com.google.protobuf.StringValue;
import java.lang.ref.WeakReference;
import java.lang.reflect.InvocationTargetException;
import java.lang.reflect.Method;
import java.lang.reflect.Modifier;
import java.time.Duration;
import java.util.List;
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

/** What the tests share, and what runs them: each public static method of a class is a test in a domain of its own. */
final class Expect {
  static final Duration PATIENCE = Duration.ofSeconds(45);
  static final StringValue TEXT = StringValue.getDefaultInstance();

  private static String domain;

  private Expect() {}

  /** Runs the tests of a class one after the other. */
  public static void main(String[] arguments) throws ReflectiveOperationException {
    int failed = 0;
    int run = 0;
    for (Method test : Class.forName(arguments[0]).getDeclaredMethods()) {
      if (Modifier.isPublic(test.getModifiers())) {
        domain = "java-" + ProcessHandle.current().pid() + "-" + run;
        run++;
        try {
          test.invoke(null);
          System.out.println("PASS " + test.getName());
        } catch (InvocationTargetException e) {
          System.out.println("FAIL " + test.getName());
          e.getCause().printStackTrace(System.out);
          failed++;
        }
      }
    }
    System.out.println(run + " run, " + failed + " failed");
    System.exit(failed == 0 && run > 0 ? 0 : 1); // Also if a test has left a thread.
  }

  /** The action of a test that may throw. */
  interface Action {
    void run() throws Exception;
  }

  static Session session(String name) {
    return session(new SessionOptions().name(name));
  }

  static Session session(SessionOptions options) {
    return Session.open("discovery: {domain: " + domain + "}", options);
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

  static <T extends Throwable> T thrown(Class<T> type, Action action) throws Exception {
    try {
      action.run();
    } catch (Throwable e) {
      if (type.isInstance(e)) {
        return type.cast(e);
      }
      throw e;
    }
    throw new AssertionError("there was no " + type.getName());
  }

  /** The sentence of the failure. */
  static String fails(Code code, Action action) throws Exception {
    HgrosException failure = thrown(HgrosException.class, action);
    if (failure.code() != code) {
      throw failure;
    }
    return failure.getMessage();
  }

  /** Each of them is an argument that the binding refuses with these words. */
  static void refused(List<Action> uses, String... words) throws Exception {
    for (Action use : uses) {
      String sentence = fails(Code.INVALID_ARGUMENT, use);
      for (String word : words) {
        holds(sentence.contains(word), sentence);
      }
    }
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

  static void ends(Future<?> future, Code code) throws Exception {
    equal(((HgrosException) failure(future)).code(), code);
  }

  static Throwable failure(Future<?> future) throws Exception {
    return thrown(ExecutionException.class, () -> future.get(PATIENCE.toSeconds(), TimeUnit.SECONDS)).getCause();
  }

  static void eventually(String what, Callable<Boolean> condition) throws Exception {
    long end = System.nanoTime() + PATIENCE.toNanos();
    while (!condition.call()) {
      holds(System.nanoTime() < end, what + " did not hold in time");
      Thread.sleep(2);
    }
  }

  static void eventuallyFails(String what, Code code, Action action) throws Exception {
    eventually(what, () -> {
      try {
        action.run();
        return false;
      } catch (HgrosException e) {
        return e.code() == code;
      }
    });
  }
}
