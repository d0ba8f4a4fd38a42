package org.hgros;

import com.google.protobuf.Message;
import java.lang.ref.Reference;

/** Offers a service until it or its session is closed. */
public final class Service implements AutoCloseable {
  private final Session session;
  private final Handle handle;

  <Q extends Message, R extends Message> Service(Session session, String name, Q request, R reply,
      ServiceHandler<Q, R> handler, ServeOptions options) {
    this.session = session;
    Texts.checked("The name of the service", name);
    Callbacks.ServiceTarget target = message -> {
      Reference.reachabilityFence(session); // Not forgotten while it serves.
      return handler.handle(ReceivedMessage.parse(message, request)).toByteArray();
    };
    Structs.ServeOptions chosen = new Structs.ServeOptions();
    chosen.most_waiting = options.mostWaiting;
    chosen.concurrent = options.concurrent ? 1 : 0;
    Schema requests = Schema.of(request.getDescriptorForType());
    Schema replies = Schema.of(reply.getDescriptorForType());
    long[] opened = new long[1];
    session.handle.call(owner -> requests.handle.status(requestType -> replies.handle.status(
        replyType -> HgrosC.hgros_serve(owner, name, requestType, replyType, chosen, Callbacks.SERVE,
            Callbacks.keep(target), Callbacks.RELEASE, opened))));
    handle = new Handle("service \"" + name + "\"", opened[0], pointer -> {
      HgrosC.hgros_service_close(pointer);
      return 0;
    });
  }

  /** Withdraws the service: requests that wait fail. Outside handlers it waits for the running ones. */
  @Override
  public void close() {
    session.forget(this);
    handle.close();
  }
}
