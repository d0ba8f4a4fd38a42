package org.hgros;

import com.sun.jna.Callback;
import com.sun.jna.CallbackReference;
import com.sun.jna.CallbackThreadInitializer;
import com.sun.jna.Native;
import com.sun.jna.Pointer;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.ConcurrentMap;
import java.util.concurrent.atomic.AtomicLong;

/**
 * The functions that the library calls. There is one of each kind, which is never collected; `user` is the number of
 * its target in Java, which lives until the library releases it. They run on threads of the library, which stay
 * attached to the virtual machine as daemons. Nothing is thrown into the library.
 */
final class Callbacks {
  /** Targets, by kind. */
  interface LogTarget {
    void line(int level, String text);
  }

  interface ServiceTarget {
    byte[] answer(long request) throws Exception;
  }

  interface ReplyTarget {
    void ended(int status, String sentence, long reply);
  }

  interface ChangeTarget {
    void changed(String path, String yaml);
  }

  interface PeerTarget {
    void happened(int event, long peer, String channel, String reason);
  }

  /** What C sees. */
  private interface Release extends Callback {
    void invoke(long user);
  }

  private interface Log extends Callback {
    void invoke(long user, int level, long text);
  }

  private interface Serve extends Callback {
    void invoke(long user, long request, long reply);
  }

  private interface Reply extends Callback {
    void invoke(long user, int status, long sentence, long reply);
  }

  private interface Change extends Callback {
    void invoke(long user, long path, long yaml);
  }

  private interface PeerEvent extends Callback {
    void invoke(long user, int event, long peer, long channel, long reason);
  }

  private static final ConcurrentMap<Long, Object> TARGETS = new ConcurrentHashMap<>();
  private static final AtomicLong NUMBER = new AtomicLong();
  private static final ThreadLocal<Boolean> INSIDE = ThreadLocal.withInitial(() -> false);

  private static final Release RELEASE_CALLBACK = user -> TARGETS.remove(user);
  private static final Log LOG_CALLBACK =
      (user, level, text) -> run(() -> Callbacks.<LogTarget>target(user).line(level, HgrosC.textAt(text)));
  private static final Serve SERVE_CALLBACK = (user, request, reply) -> run(() -> serve(target(user), request, reply));
  private static final Reply REPLY_CALLBACK = (user, status, sentence, reply) -> run(
      () -> Callbacks.<ReplyTarget>target(user).ended(status, HgrosC.textAt(sentence), reply));
  private static final Change CHANGE_CALLBACK = (user, path, yaml) -> run(
      () -> Callbacks.<ChangeTarget>target(user).changed(HgrosC.textAt(path), yaml == 0 ? null : HgrosC.textAt(yaml)));
  private static final PeerEvent PEER_CALLBACK = (user, event, peer, channel, reason) -> run(
      () -> Callbacks.<PeerTarget>target(user).happened(event, peer, HgrosC.textAt(channel), HgrosC.textAt(reason)));

  static final long RELEASE = addressOf(RELEASE_CALLBACK);
  static final long LOG = addressOf(LOG_CALLBACK);
  static final long SERVE = addressOf(SERVE_CALLBACK);
  static final long REPLY = addressOf(REPLY_CALLBACK);
  static final long CHANGE = addressOf(CHANGE_CALLBACK);
  static final long PEER = addressOf(PEER_CALLBACK);

  private Callbacks() {}

  private static long addressOf(Callback callback) {
    Native.setCallbackThreadInitializer(callback, new CallbackThreadInitializer(true, false, "hgros"));
    return Pointer.nativeValue(CallbackReference.getFunctionPointer(callback));
  }

  /** The number of a target, for the library to carry as `user`. */
  static long keep(Object target) {
    long user = NUMBER.incrementAndGet();
    TARGETS.put(user, target);
    return user;
  }

  /** The library was not called with it. */
  static void forget(long user) {
    TARGETS.remove(user);
  }

  @SuppressWarnings("unchecked") // Each kind of callback is registered with its kind of target.
  private static <T> T target(long user) {
    return (T) TARGETS.get(user);
  }

  /** Whether this thread runs a callback of the library, which must not wait for itself. */
  static boolean inside() {
    return INSIDE.get();
  }

  private static void run(Runnable body) {
    boolean before = INSIDE.get();
    INSIDE.set(true);
    try {
      body.run();
    } catch (Throwable e) { // Targets report their own; this is a fault of the log's function, or no memory.
      reportUncaught(e);
    } finally {
      INSIDE.set(before);
    }
  }

  /** For what no session's log takes: the handler of uncaught exceptions, by default standard error. */
  static void reportUncaught(Throwable thrown) {
    try {
      Thread thread = Thread.currentThread();
      thread.getUncaughtExceptionHandler().uncaughtException(thread, thrown);
    } catch (Throwable e) {
      // There is nobody left to tell.
    }
  }

  /** What a program's exception says, whose methods may throw themselves. */
  private static String sentenceOf(Throwable thrown) {
    try {
      return String.valueOf(thrown.getMessage() == null ? thrown.toString() : thrown.getMessage());
    } catch (Throwable e) {
      return thrown.getClass().getName();
    }
  }

  private static void serve(ServiceTarget target, long request, long reply) {
    String failure;
    try {
      byte[] answer = target.answer(request);
      if (HgrosC.hgros_reply_set(reply, answer, answer.length) == 0) {
        return;
      }
      failure = HgrosC.textAt(HgrosC.hgros_last_error());
    } catch (Throwable e) {
      failure = sentenceOf(e);
    }
    HgrosC.hgros_reply_fail(reply, failure.replace('\0', ' '));
  }
}
