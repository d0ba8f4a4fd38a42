import com.google.protobuf.StringValue;
import java.time.Duration;
import java.util.ArrayList;
import java.util.Collections;
import java.util.List;
import java.util.concurrent.ArrayBlockingQueue;
import java.util.concurrent.BlockingQueue;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.ExecutorService;
import java.util.concurrent.Executors;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.concurrent.atomic.AtomicReference;
import org.hgros.Code;
import org.hgros.HgrosException;
import org.hgros.Publisher;
import org.hgros.RawSubscription;
import org.hgros.ReceivedMessage;
import org.hgros.Session;
import org.hgros.SessionOptions;
import org.hgros.SubscribeOptions;
import org.hgros.Subscription;
import org.hgros.SubscriptionStats;

final class QueuesTest {
  private QueuesTest() {}

  private static StringValue text(Object value) {
    return StringValue.of(value.toString());
  }

  public static void queuesDropOrHoldBack() throws Exception {
    try (Session session = Expect.session("queues")) {
      Subscription<StringValue> newest = session.subscribe("newest", Expect.TEXT, new SubscribeOptions().keepLast(2));
      Subscription<StringValue> every = session.subscribe("every", Expect.TEXT, new SubscribeOptions().keepAll(2));
      Publisher<StringValue> dropping = session.advertise("newest", Expect.TEXT);
      Publisher<StringValue> lossless = session.advertise("every", Expect.TEXT);
      for (int i = 0; i < 5; i++) {
        dropping.publish(text(i));
      }
      Expect.equal(newest.stats(), new SubscriptionStats(5, 3, 0, 2, 0, 0));
      Expect.equal(newest.next().getValue(), "3");
      lossless.publish(text(1));
      lossless.publish(text(2));
      Expect.fails(Code.FULL, () -> lossless.publish(text(3)));
      Expect.fails(Code.TIMED_OUT, () -> lossless.publish(text(3), Duration.ofMillis(20)));
      Expect.fails(Code.TIMED_OUT, () -> lossless.publish(text(3), Duration.ofNanos(1)));
      every.next();
      lossless.publish(text(3), Expect.PATIENCE);
    }
  }

  public static void whatWaitsIsWoken() throws Exception {
    Session session = Expect.session("waits");
    Subscription<StringValue> closed = session.subscribe("a", Expect.TEXT);
    Subscription<StringValue> ended = session.subscribe("b", Expect.TEXT);
    Publisher<StringValue> publisher = session.advertise("c", Expect.TEXT);
    Subscription<StringValue> full = session.subscribe("c", Expect.TEXT, new SubscribeOptions().keepAll(1));
    publisher.publish(text("fills it"));
    Waiting interrupted = new Waiting(closed::next);
    interrupted.thread.interrupt();
    Expect.holds(interrupted.end() instanceof InterruptedException, interrupted.end());
    Waiting one = new Waiting(closed::next);
    Waiting two = new Waiting(() -> closed.raw().take());
    closed.close();
    one.endsWith(Code.CLOSED);
    two.endsWith(Code.CLOSED);
    Waiting next = new Waiting(ended::next);
    Waiting subscribers = new Waiting(() -> session.waitForSubscribers("c", 5, Expect.PATIENCE));
    Waiting room = new Waiting(() -> publisher.publish(text("waits"), Expect.PATIENCE));
    session.end();
    next.endsWith(Code.CLOSED);
    subscribers.endsWith(Code.CLOSED);
    room.endsWith(Code.CLOSED);
    Expect.fails(Code.CLOSED, full::next);
    session.close();
  }

  /** A thread that waits. */
  private static final class Waiting {
    final Thread thread;
    private final BlockingQueue<Throwable> result = new ArrayBlockingQueue<>(1);
    private Throwable end;

    Waiting(Expect.Action action) throws Exception {
      thread = new Thread(() -> {
        try {
          action.run();
          result.add(new AssertionError("it did not fail"));
        } catch (Throwable e) {
          result.add(e);
        }
      });
      thread.start();
      Expect.eventually("the thread waits", () -> thread.getState() != Thread.State.NEW && !thread.isInterrupted());
    }

    Throwable end() throws InterruptedException {
      if (end == null) {
        end = result.poll(Expect.PATIENCE.toSeconds(), TimeUnit.SECONDS);
      }
      return end;
    }

    void endsWith(Code code) throws InterruptedException {
      Expect.holds(end() instanceof HgrosException failure && failure.code() == code, end());
    }
  }

  public static void severalTakersShareTheMessages() throws Exception {
    try (Session session = Expect.session("shared")) {
      Subscription<StringValue> queue = session.subscribe("work", Expect.TEXT, new SubscribeOptions().keepAll(10));
      Publisher<StringValue> publisher = session.advertise("work", Expect.TEXT);
      AtomicInteger sum = new AtomicInteger();
      CountDownLatch left = new CountDownLatch(2000);
      for (int i = 0; i < 4; i++) {
        new Thread(() -> {
          try {
            while (true) {
              sum.addAndGet(Integer.parseInt(queue.next().getValue()));
              left.countDown();
            }
          } catch (HgrosException | InterruptedException e) {
            // The session is closed.
          }
        }).start();
      }
      for (int i = 0; i < 2000; i++) {
        publisher.publish(text(i), Expect.PATIENCE);
      }
      Expect.passes(left);
      Expect.equal(sum.get(), 1999 * 2000 / 2);
    }
  }

  public static void callbacksRunInOrderOnAnExecutorOfTheProgram() throws Exception {
    ExecutorService executor = Executors.newSingleThreadExecutor(task -> new Thread(task, "mine"));
    try (Session from = Expect.session("from"); Session to = Expect.session("to")) {
      List<String> got = Collections.synchronizedList(new ArrayList<>());
      List<String> threads = Collections.synchronizedList(new ArrayList<>());
      CountDownLatch left = new CountDownLatch(1000);
      // Nobody keeps the subscription: it lives as long as its session.
      to.subscribe("words", Expect.TEXT, new SubscribeOptions().keepAll(10)).onMessage(executor, message -> {
        got.add(message.getValue());
        threads.add(Thread.currentThread().getName());
        left.countDown();
      });
      System.gc();
      Publisher<StringValue> publisher = from.advertise("words", Expect.TEXT);
      from.waitForSubscribers("words", 1, Expect.PATIENCE);
      for (int i = 0; i < 1000; i++) {
        publisher.publish(text(i), Expect.PATIENCE);
      }
      Expect.passes(left);
      for (int i = 0; i < 1000; i++) {
        Expect.equal(got.get(i), Integer.toString(i));
        Expect.equal(threads.get(i), "mine");
      }
    } finally {
      executor.shutdown();
    }
  }

  public static void aBusyCallbackHoldsBackALosslessPublisher() throws Exception {
    try (Session session = Expect.session("busy")) {
      CountDownLatch entered = new CountDownLatch(1);
      CountDownLatch goOn = new CountDownLatch(1);
      session.subscribe("work", Expect.TEXT, new SubscribeOptions().keepAll(1)).onMessage(message -> {
        entered.countDown();
        Expect.passes(goOn);
      });
      Publisher<StringValue> publisher = session.advertise("work", Expect.TEXT);
      publisher.publish(text("runs"));
      entered.await();
      publisher.publish(text("waits"), Expect.PATIENCE);
      Expect.fails(Code.FULL, () -> publisher.publish(text("has no room")));
      goOn.countDown();
      publisher.publish(text("has room"), Expect.PATIENCE);
    }
  }

  public static void aSubscriptionIsClosedInItsCallback() throws Exception {
    try (Session session = Expect.session("ends")) {
      AtomicReference<RawSubscription> self =
          new AtomicReference<>(session.subscribeRaw("words", new SubscribeOptions()));
      AtomicInteger calls = new AtomicInteger();
      CountDownLatch closed = new CountDownLatch(1);
      self.get().onMessage(message -> {
        calls.incrementAndGet();
        self.get().close();
        closed.countDown();
      });
      Publisher<StringValue> publisher = session.advertise("words", Expect.TEXT);
      publisher.publish(text(1));
      publisher.publish(text(2));
      Expect.passes(closed);
      self.get().close(); // Waits for the callback.
      Expect.equal(calls.get(), 1);
      Expect.equal(ReceivedMessage.leases(), 0L);
    }
  }

  public static void aSessionIsClosedInACallback() throws Exception {
    Session session = Expect.session("ends");
    CountDownLatch closed = new CountDownLatch(1);
    session.subscribe("words", Expect.TEXT).onMessage(message -> {
      session.close();
      closed.countDown();
    });
    session.advertise("words", Expect.TEXT).publish(text(1));
    Expect.passes(closed);
    Expect.fails(Code.CLOSED, session::id);
  }

  public static void closingASubscriptionOrItsSessionWaitsForTheCallback() throws Exception {
    try (Session session = Expect.session("waits")) {
      closeInACallback(session, false);
    }
    closeInACallback(Expect.session("waits"), true);
  }

  // Another thread closes the session, or only its subscription, while a callback runs.
  private static void closeInACallback(Session session, boolean closesSession) throws Exception {
    CountDownLatch entered = new CountDownLatch(1);
    CountDownLatch goOn = new CountDownLatch(1);
    AtomicInteger left = new AtomicInteger();
    Subscription<StringValue> queue = session.subscribe("words", Expect.TEXT).onMessage(message -> {
      entered.countDown();
      Expect.passes(goOn);
      left.incrementAndGet();
    });
    session.advertise("words", Expect.TEXT).publish(text(1));
    entered.await();
    AtomicInteger leftAtClose = new AtomicInteger(-1);
    Thread closer = new Thread(() -> {
      if (closesSession) {
        session.close();
      } else {
        queue.close();
      }
      leftAtClose.set(left.get());
    });
    closer.start();
    Expect.eventually("close waits", () -> closer.getState() == Thread.State.WAITING);
    goOn.countDown();
    closer.join();
    Expect.equal(leftAtClose.get(), 1);
  }

  public static void anExecutorThatRefusesEndsItsSubscriptionAndWakesThoseThatTake() throws Exception {
    StringBuffer lines = new StringBuffer();
    try (Session session = Expect.session(new SessionOptions().log((level, line) -> lines.append(line)))) {
      ExecutorService executor = Executors.newSingleThreadExecutor();
      executor.shutdown();
      Subscription<StringValue> queue = session.subscribe("words", Expect.TEXT).onMessage(executor, message -> { });
      Waiting next = new Waiting(() -> {
        while (queue.next() != null) { // Each message is for one of the three.
        }
      });
      Waiting take = new Waiting(() -> {
        while (true) {
          queue.raw().take().close();
        }
      });
      Publisher<StringValue> publisher = session.advertise("words", Expect.TEXT);
      Expect.eventuallyFails("the subscription ends", Code.CLOSED, () -> {
        publisher.publish(text(1));
        queue.stats();
      });
      next.endsWith(Code.CLOSED);
      take.endsWith(Code.CLOSED);
      Expect.eventually("the log says why", () -> lines.indexOf("takes no task") >= 0);
    }
  }

  /** An exception that cannot even be described. */
  private static final class Hostile extends RuntimeException {
    private static final long serialVersionUID = 1;

    @Override
    public String getMessage() {
      throw new IllegalStateException("no message");
    }
  }

  public static void whatCallbacksThrowIsLoggedAndCountedAndStopsNoQueue() throws Exception {
    StringBuffer lines = new StringBuffer();
    SessionOptions options = new SessionOptions().log((level, line) -> lines.append(line).append('\n'));
    try (Session session = Expect.session(options)) {
      session.subscribe("refused", Expect.TEXT).onMessage(task -> {
        throw new Hostile();
      }, message -> { });
      session.advertise("refused", Expect.TEXT).publish(text("nobody runs it"));
      Expect.eventually("the executor's failure is logged", () -> lines.indexOf("takes no task") >= 0);
      CountDownLatch last = new CountDownLatch(1);
      Subscription<StringValue> queue =
          session.subscribe("words", Expect.TEXT, new SubscribeOptions().keepAll(10)).onMessage(message -> {
            switch (message.getValue()) {
              case "last" -> last.countDown();
              case "bad" -> throw new Hostile();
              default -> throw new IllegalStateException("a " + message.getValue());
            }
          });
      Publisher<StringValue> publisher = session.advertise("words", Expect.TEXT);
      for (String word : List.of("mouse", "cat", "bad", "last")) {
        publisher.publish(text(word));
      }
      Expect.passes(last);
      Expect.equal(queue.stats().failed(), 3L);
      Expect.eventually("the log names both", () -> lines.indexOf("\"words\" failed: QueuesTest$Hostile") >= 0
          && lines.indexOf(
              "The callback of channel \"words\" failed: java.lang.IllegalStateException: a mouse at QueuesTest") >= 0);
    }
  }

  public static void callbacksCloseEachOther() throws Exception {
    try (Session session = Expect.session("mutual")) {
      List<Subscription<StringValue>> both = new ArrayList<>();
      CountDownLatch inside = new CountDownLatch(2);
      CountDownLatch closed = new CountDownLatch(2);
      for (int i = 0; i < 2; i++) {
        both.add(session.subscribe("words", Expect.TEXT));
      }
      for (int i = 0; i < 2; i++) {
        Subscription<StringValue> other = both.get(1 - i);
        both.get(i).onMessage(message -> {
          inside.countDown();
          Expect.passes(inside);
          other.close();
          closed.countDown();
        });
      }
      session.advertise("words", Expect.TEXT).publish(text(1));
      Expect.passes(closed);
    }
  }

  public static void whatCallbacksReadIsThereWhileOthersClose() throws Exception {
    try (Session from = Expect.session("from")) {
      Publisher<StringValue> publisher = from.advertise("words", Expect.TEXT);
      StringValue large = text("x".repeat(100_000)); // Leases on shared memory.
      Thread publishing = new Thread(() -> {
        try {
          while (true) {
            publisher.publish(large, Expect.PATIENCE);
          }
        } catch (HgrosException | InterruptedException e) {
          // The session is closed.
        }
      });
      publishing.start();
      AtomicInteger wrong = new AtomicInteger();
      for (int round = 0; round < 40; round++) {
        Session to = Expect.session("to");
        AtomicInteger runs = new AtomicInteger();
        AtomicInteger calls = new AtomicInteger();
        RawSubscription raw = to.subscribeRaw("words", new SubscribeOptions().keepAll(4));
        raw.onMessage(message -> {
          runs.incrementAndGet();
          java.nio.ByteBuffer data = message.data();
          for (int i = 100; i < data.limit(); i += 1000) {
            if (data.get(i) != 'x') {
              wrong.incrementAndGet();
            }
          }
          calls.incrementAndGet();
          runs.decrementAndGet();
        });
        int wanted = round % 5;
        Expect.eventually("messages come", () -> calls.get() > wanted);
        if (round % 2 == 0) {
          raw.close();
        } else {
          to.close();
        }
        Expect.equal(runs.get(), 0);
        int after = calls.get();
        to.close();
        Expect.equal(calls.get(), after);
      }
      Expect.equal(wrong.get(), 0);
      from.close();
      publishing.join();
      Expect.equal(ReceivedMessage.leases(), 0L);
    }
  }
}
