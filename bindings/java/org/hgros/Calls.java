package org.hgros;

import com.google.protobuf.Message;
import java.time.Duration;
import java.util.concurrent.CompletableFuture;

/** The caller's side of services. */
final class Calls {
  private Calls() {}

  @FunctionalInterface
  private interface Calling {
    int call(long session, long requestType, byte[] data, long replyType);
  }

  private static void start(Session session, String name, Message request, Message reply, Calling calling) {
    Schema requests = Schema.of(request.getDescriptorForType());
    Schema replies = Schema.of(reply.getDescriptorForType());
    Texts.checked("The name of the service", name);
    byte[] data = request.toByteArray();
    session.handle.call(owner -> requests.handle.status(
        requestType -> replies.handle.status(replyType -> calling.call(owner, requestType, data, replyType))));
  }

  static <R extends Message> R call(Session session, String name, Message request, R reply, Duration timeout) {
    long[] got = new long[1];
    start(session, name, request, reply, (owner, requestType, data, replyType) -> HgrosC.hgros_call(
        owner, name, requestType, data, data.length, replyType, Waits.nanos(timeout), got));
    try {
      return ReceivedMessage.parse(got[0], reply);
    } finally {
      HgrosC.hgros_message_free(got[0]);
    }
  }

  static <R extends Message> CompletableFuture<R> callLater(Session session, String name, Message request, R reply,
      Duration timeout) {
    CompletableFuture<R> future = new CompletableFuture<>();
    Callbacks.ReplyTarget target = (status, sentence, message) -> end(future, status, sentence, message, reply);
    long[] opened = new long[1];
    start(session, name, request, reply, (owner, requestType, data, replyType) -> HgrosC.hgros_call_later(
        owner, name, requestType, data, data.length, replyType, Waits.nanos(timeout), Callbacks.REPLY,
        Callbacks.keep(target), Callbacks.RELEASE, opened));
    Handle pending = new Handle("call", opened[0], pointer -> {
      HgrosC.hgros_call_free(pointer);
      return 0;
    });
    future.whenComplete((result, failure) -> {
      if (future.isCancelled()) {
        pending.status(call -> {
          HgrosC.hgros_call_cancel(call);
          return 0;
        });
      }
      pending.close();
    });
    return future;
  }

  /** What depends on the future does not run on a thread of the library, which other calls need. */
  private static <R extends Message> void end(CompletableFuture<R> future, int status, String sentence, long message,
      R reply) {
    try {
      if (status != 0) {
        throw new HgrosException(Code.of(status), sentence);
      }
      R result = ReceivedMessage.parse(message, reply);
      Workers.ANY.execute(() -> future.complete(result));
    } catch (Throwable e) {
      Workers.ANY.execute(() -> future.completeExceptionally(e));
    }
  }
}
