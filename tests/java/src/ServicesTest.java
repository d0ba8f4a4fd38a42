import com.google.protobuf.Message;
import com.google.protobuf.StringValue;
import com.google.protobuf.Struct;
import java.lang.ref.WeakReference;
import java.lang.reflect.Proxy;
import java.time.Duration;
import java.util.concurrent.CancellationException;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.CountDownLatch;
import org.hgros.Code;
import org.hgros.HgrosException;
import org.hgros.Peer;
import org.hgros.PeerEvent;
import org.hgros.PeerListener;
import org.hgros.ServeOptions;
import org.hgros.Service;
import org.hgros.Session;

final class ServicesTest {
  private ServicesTest() {}

  private static StringValue call(Session session, String name, String text) {
    return session.call(name, StringValue.of(text), Expect.TEXT, Expect.PATIENCE);
  }

  private static void awaitService(Session session, String name) throws Exception {
    Expect.eventually("the service is known", () -> {
      try {
        return call(session, name, "hello") != null;
      } catch (HgrosException e) {
        Expect.equal(e.code(), Code.NO_SERVER);
        return false;
      }
    });
  }

  public static void servicesReplyFailAndThrow() throws Exception {
    try (Session server = Expect.session("server"); Session client = Expect.session("client")) {
      Service service = server.serve("shout", Expect.TEXT, Expect.TEXT, word -> {
        switch (word.getValue()) {
          case "fail":
            throw new Exception("I have no voice");
          case "null":
            return null;
          case "error":
            throw new StackOverflowError();
          default:
            return StringValue.of(word.getValue().toUpperCase());
        }
      });
      awaitService(client, "shout");
      Expect.equal(call(client, "shout", "gr\u00fc\u00df"), StringValue.of("GR\u00dcSS"));
      Expect.equal(Expect.fails(Code.HANDLER_FAILED, () -> call(client, "shout", "fail")), "I have no voice");
      Expect.fails(Code.HANDLER_FAILED, () -> call(client, "shout", "null"));
      String sentence = Expect.fails(Code.HANDLER_FAILED, () -> call(client, "shout", "error"));
      Expect.equal(sentence, "java.lang.StackOverflowError");
      Expect.equal(call(client, "shout", "on"), StringValue.of("ON"));
      Expect.fails(Code.NO_SERVER, () -> call(client, "nobody", ""));
      Expect.fails(Code.TYPE_MISMATCH,
          () -> client.call("shout", Struct.getDefaultInstance(), Expect.TEXT, Expect.PATIENCE));
      service.close();
      service.close();
      Expect.eventuallyFails("the service is withdrawn", Code.NO_SERVER, () -> call(client, "shout", "x"));
    }
  }

  public static void aCallEndsWithItsTimeoutOrIsCancelled() throws Exception {
    CountDownLatch goOn = new CountDownLatch(1);
    CountDownLatch entered = new CountDownLatch(2);
    try (Session server = Expect.session("server"); Session client = Expect.session("client")) {
      server.serve("sleep", Expect.TEXT, Expect.TEXT, word -> {
        if (word.getValue().equals("wait")) {
          entered.countDown();
          goOn.await();
        }
        return word;
      }, new ServeOptions().concurrent());
      awaitService(client, "sleep");
      StringValue wait = StringValue.of("wait");
      Expect.fails(Code.TIMED_OUT, () -> client.call("sleep", wait, Expect.TEXT, Duration.ofMillis(50)));
      CompletableFuture<StringValue> later = client.callLater("sleep", wait, Expect.TEXT, Expect.PATIENCE);
      Expect.passes(entered);
      later.cancel(true);
      Expect.thrown(CancellationException.class, later::get);
      goOn.countDown();
      StringValue word = StringValue.of("word");
      CompletableFuture<String> thread = client.callLater("sleep", word, Expect.TEXT, Expect.PATIENCE)
          .thenApply(reply -> reply.getValue() + " on " + Thread.currentThread().getName());
      Expect.holds(thread.get().matches("word on (hgros-callback-[0-9]+|main)"), thread.get());
      Expect.ends(client.callLater("nobody", word, Expect.TEXT, Expect.PATIENCE), Code.NO_SERVER);
    } finally {
      goOn.countDown();
    }
  }

  public static void aSessionThatOnlyServesLives() throws Exception {
    try (Session client = Expect.session("client")) {
      Expect.session("server").serve("echo", Expect.TEXT, Expect.TEXT, word -> word);
      awaitService(client, "echo");
      Expect.collected(new WeakReference<>(new Object()));
      for (int i = 0; i < 100; i++) { // The cleaner has a thread of its own.
        Expect.equal(call(client, "echo", "on"), StringValue.of("on"));
      }
    }
  }

  public static void aHandlerCallsItsOwnSession() throws Exception {
    try (Session session = Expect.session("both")) {
      session.serve("inner", Expect.TEXT, Expect.TEXT, word -> StringValue.of("<" + word.getValue() + ">"));
      session.serve("outer", Expect.TEXT, Expect.TEXT, word -> call(session, "inner", word.getValue()));
      Expect.equal(call(session, "outer", "x").getValue(), "<x>");
    }
  }

  public static void aSessionIsClosedInAHandler() throws Exception {
    Session server = Expect.session("server");
    try (Session client = Expect.session("client")) {
      server.serve("end", Expect.TEXT, Expect.TEXT, word -> {
        if (word.getValue().equals("now")) {
          server.close();
        }
        return word;
      });
      awaitService(client, "end");
      try {
        call(client, "end", "now");
      } catch (HgrosException e) {
        Expect.equal(e.code(), Code.SERVER_GONE);
      }
      Expect.fails(Code.CLOSED, server::id);
    }
  }

  public static void aLaterCallEndsWithAnyFailure() throws Exception {
    Message unreadable = (Message) Proxy.newProxyInstance(Message.class.getClassLoader(),
        new Class<?>[] {Message.class}, (proxy, method, arguments) -> {
          if (method.getName().equals("getDescriptorForType")) {
            return StringValue.getDescriptor();
          }
          throw new StackOverflowError("no " + method.getName());
        });
    try (Session session = Expect.session("later")) {
      session.serve("echo", Expect.TEXT, Expect.TEXT, word -> word);
      CompletableFuture<Message> reply = session.callLater("echo", Expect.TEXT, unreadable, Expect.PATIENCE);
      Expect.holds(Expect.failure(reply) instanceof StackOverflowError, reply);
    }
  }

  public static void whatAClosedSessionRefusesIsCollected() throws Exception {
    Session session = Expect.session("closed");
    session.close();
    WeakReference<Object> target = refused(session);
    Expect.collected(target);
  }

  private static WeakReference<Object> refused(Session session) throws Exception {
    PeerListener listener = new PeerListener() {
      @Override
      public void happened(PeerEvent event, Peer peer, String channel, String reason) {}
    };
    Expect.fails(Code.CLOSED, () -> session.onPeer(listener));
    return new WeakReference<>(listener);
  }
}
