package org.hgros;

import com.google.protobuf.Message;
import com.sun.jna.Pointer;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.Set;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.ConcurrentHashMap;

/**
 * One participant of the hypergraph. All methods of the package may be called by any thread. Waits end with an
 * InterruptedException if their thread is interrupted.
 */
public final class Session implements AutoCloseable {
  final Handle handle;
  private final Set<AutoCloseable> children = ConcurrentHashMap.newKeySet();

  @FunctionalInterface
  private interface Opening {
    int open(Structs.SessionOptions options, long[] session);
  }

  private Session(SessionOptions options, Opening opening) {
    Structs.SessionOptions chosen = new Structs.SessionOptions();
    chosen.name = Texts.checked("The name of the session", options.name);
    if (options.log != null) {
      Callbacks.LogTarget target = (level, text) -> options.log.accept(LogLevel.of(level), text);
      chosen.log = Callbacks.LOG;
      chosen.log_user = Callbacks.keep(target);
      chosen.log_release = Callbacks.RELEASE;
    }
    long[] opened = new long[1];
    HgrosC.check(opening.open(chosen, opened));
    handle = new Handle("session", opened[0], pointer -> {
      HgrosC.hgros_session_close(pointer);
      return 0;
    }).closeWith(this);
  }

  /** Opens a session that finds the other sessions of this user on this host. HGROS_DOMAIN is the domain. */
  public static Session open() {
    return open("");
  }

  /** Opens a session with a configuration as YAML text. */
  public static Session open(String yaml) {
    return open(yaml, new SessionOptions());
  }

  /** Opens a session with a configuration as YAML text. */
  public static Session open(String yaml, SessionOptions options) {
    Texts.checked("The configuration", yaml);
    return new Session(options, (chosen, session) -> HgrosC.hgros_session_open(yaml, chosen, session));
  }

  /** Opens a session with configuration files, which are merged. */
  public static Session openFiles(List<Path> files, SessionOptions options) {
    Pointer paths = texts(files);
    return new Session(options,
        (chosen, session) -> HgrosC.hgros_session_open_files(paths, files.size(), chosen, session));
  }

  /**
   * Wakes all that wait for the session, and every later call throws {@link Code#CLOSED}. Does not wait. Close it
   * later.
   */
  public void end() {
    try {
      handle.status(session -> {
        HgrosC.hgros_session_end(session);
        return 0;
      });
    } catch (HgrosException e) {
      // Closed already.
    }
  }

  /**
   * Ends the session, waits for running handlers and callbacks, and says goodbye to the other sessions. Inside a
   * callback it does not wait for others; inside a handler the rest stays until the process ends.
   */
  @Override
  public void close() {
    end();
    handle.close();
    if (!Callbacks.inside()) {
      handle.awaitFreed();
    }
    for (AutoCloseable child : children) {
      try {
        child.close();
      } catch (Exception e) {
        throw new IllegalStateException(e); // Services, watches and subscriptions throw nothing.
      }
    }
  }

  /** Makes a child live until it is closed or its session is. */
  <C extends AutoCloseable> C keep(C child) {
    children.add(child);
    return child;
  }

  void forget(AutoCloseable child) {
    children.remove(child);
  }

  /** The session's name. */
  public String name() {
    long session = handle.enter();
    try {
      return HgrosC.textAt(HgrosC.hgros_session_name(session));
    } finally {
      handle.leave();
    }
  }

  /** The session's id, as {@link MessageInfo#publisher} of its messages has it. */
  public long id() {
    long session = handle.enter();
    try {
      return HgrosC.hgros_session_id(session);
    } finally {
      handle.leave();
    }
  }

  /** Writes a line into the session's log. */
  public void log(LogLevel level, String line) {
    Texts.checked("The line for the log", line);
    handle.call(session -> HgrosC.hgros_session_log(session, level.ordinal(), line));
  }

  /** Writes what a callback has thrown into the log: ten times for each `what`, then less and less often. */
  void report(String what, Throwable thrown) {
    String line = (what + ": " + described(thrown) + ".").replaceAll("\\p{Cntrl}", " ");
    try {
      handle.call(session -> HgrosC.hgros_session_log_limited(session, LogLevel.ERROR.ordinal(), what, line));
    } catch (HgrosException e) {
      // The session is closed, and so is its log.
    }
  }

  /** What a program's exception is, whose methods may throw themselves. */
  private static String described(Throwable thrown) {
    try {
      StackTraceElement[] frames = thrown.getStackTrace();
      return thrown + (frames.length == 0 ? "" : " at " + frames[0]);
    } catch (Throwable e) {
      return thrown.getClass().getName();
    }
  }

  /**
   * Announces a channel of the type of `prototype`, such as {@code Log.getDefaultInstance()}. Its description goes with
   * it.
   */
  public <T extends Message> Publisher<T> advertise(String channel, T prototype) {
    return advertise(channel, prototype, new PublishOptions());
  }

  /** The same with options. */
  public <T extends Message> Publisher<T> advertise(String channel, T prototype, PublishOptions options) {
    return new Publisher<>(this, channel, prototype, options);
  }

  /** Announces a channel of a type whose messages are given as bytes. */
  public RawPublisher advertiseRaw(String channel, Schema schema, PublishOptions options) {
    return new RawPublisher(this, channel, schema, options);
  }

  /**
   * Receives a channel of the type of `prototype`, such as {@code Log.getDefaultInstance()}: the 16 newest messages
   * wait.
   */
  public <T extends Message> Subscription<T> subscribe(String channel, T prototype) {
    return subscribe(channel, prototype, new SubscribeOptions());
  }

  /** The same with options. */
  public <T extends Message> Subscription<T> subscribe(String channel, T prototype, SubscribeOptions options) {
    return new Subscription<>(this, channel, prototype, options);
  }

  /** Receives a channel of any type as bytes. */
  public RawSubscription subscribeRaw(String channel, SubscribeOptions options) {
    return new RawSubscription(this, channel, null, options);
  }

  /** Receives a channel of one type as bytes. Messages of another type are counted, not delivered. */
  public RawSubscription subscribeRaw(String channel, Schema schema, SubscribeOptions options) {
    return new RawSubscription(this, channel, schema, options);
  }

  /** Waits until a channel that this session publishes has at least `count` subscribers. */
  public void waitForSubscribers(String channel, int count, Duration timeout) throws InterruptedException {
    Texts.checked("The name of the channel", channel);
    HgrosC.check(Waits.inSlices(timeout, slice -> handle.status(
        session -> HgrosC.hgros_session_wait_for_subscribers(session, channel, count, slice))));
  }

  /** Waits until at least `count` other sessions that publish on a channel are connected. */
  public void waitForPublishers(String channel, int count, Duration timeout) throws InterruptedException {
    Texts.checked("The name of the channel", channel);
    HgrosC.check(Waits.inSlices(timeout, slice -> handle.status(
        session -> HgrosC.hgros_session_wait_for_publishers(session, channel, count, slice))));
  }

  /**
   * Offers a service, until it or the session is closed. The handler gets requests of the type of `request`, and
   * returns replies of that of `reply`. It runs on a thread of the session, one request at a time.
   */
  public <Q extends Message, R extends Message> Service serve(String name, Q request, R reply,
      ServiceHandler<Q, R> handler) {
    return serve(name, request, reply, handler, new ServeOptions());
  }

  /** The same with options. */
  public <Q extends Message, R extends Message> Service serve(String name, Q request, R reply,
      ServiceHandler<Q, R> handler, ServeOptions options) {
    return keep(new Service(this, name, request, reply, handler, options));
  }

  /**
   * Calls a service and waits for its reply, of the type of `reply`. May be called in a handler: it handles other
   * requests of the session meanwhile. Only the timeout or the end of the session ends the wait; use callLater() to be
   * interrupted.
   */
  public <R extends Message> R call(String name, Message request, R reply, Duration timeout) {
    return Calls.call(this, name, request, reply, timeout);
  }

  /** Calls a service. The future ends on a thread of this package; to cancel it cancels the call. */
  public <R extends Message> CompletableFuture<R> callLater(String name, Message request, R reply, Duration timeout) {
    return Calls.callLater(this, name, request, reply, timeout);
  }

  /**
   * Reads the parameters of this program from YAML files, later ones over earlier ones. Other sessions may read, watch
   * and set them under the session's name.
   */
  public Params params(Path... files) {
    List<Path> list = List.of(files);
    return new Params(this, (session, params) -> HgrosC.hgros_params_open(session, texts(list), list.size(), params));
  }

  /**
   * The parameters that a session offers under its name. Each method on them asks that session and waits for its
   * answer.
   */
  public Params paramsOf(String name, Duration timeout) {
    Texts.checked("The name of the other session", name);
    return new Params(this,
        (session, params) -> HgrosC.hgros_params_of(session, name, Waits.nanos(timeout), params));
  }

  /** Opens the transforms of the session, which has one at a time. */
  public Transforms transforms() {
    return new Transforms(this);
  }

  /** The sessions that are connected with this one, at one moment. */
  public List<Peer> peers() {
    long[] opened = new long[1];
    handle.call(session -> HgrosC.hgros_peers_open(session, opened));
    try {
      List<Peer> peers = new ArrayList<>();
      long count = HgrosC.hgros_peers_count(opened[0]);
      for (long i = 0; i < count; i++) {
        Structs.Peer peer = new Structs.Peer();
        HgrosC.check(HgrosC.hgros_peers_get(opened[0], i, peer));
        peers.add(new Peer(peer));
      }
      return peers;
    } finally {
      HgrosC.hgros_peers_free(opened[0]);
    }
  }

  /** The channels of all sessions that are known, including the own, sorted by name, at one moment. */
  public List<ChannelInfo> channels() {
    long[] opened = new long[1];
    handle.call(session -> HgrosC.hgros_channels_open(session, opened));
    try {
      List<ChannelInfo> channels = new ArrayList<>();
      long count = HgrosC.hgros_channels_count(opened[0]);
      for (long i = 0; i < count; i++) {
        Structs.Channel channel = new Structs.Channel();
        HgrosC.check(HgrosC.hgros_channels_get(opened[0], i, channel));
        channels.add(new ChannelInfo(channel.name, channel.type_name, channel.fingerprint,
            Encoding.of(channel.encoding),
            channel.publishers, channel.subscribers));
      }
      return channels;
    } finally {
      HgrosC.hgros_channels_free(opened[0]);
    }
  }

  /** Calls `listener` on a thread of the session when something happens to another session; one call at a time. */
  public Watch onPeer(PeerListener listener) {
    return Watch.open(this, this, "The listener for peers",
        runner -> (Callbacks.PeerTarget) (event, peer, channel, reason) -> runner.run(() -> listener.happened(
            PeerEvent.of(event), new Peer(new Structs.Peer(new Pointer(peer))), channel, reason)),
        (user, watch) -> handle.status(
            session -> HgrosC.hgros_watch_peers(session, Callbacks.PEER, user, Callbacks.RELEASE, watch)));
  }

  private static Pointer texts(List<Path> files) {
    return Texts.list("The path of a file", files.stream().map(Path::toString).toArray(String[]::new));
  }
}
