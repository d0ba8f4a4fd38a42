using System;

namespace Hgros {
  /// <summary>Calls a function with each message of a channel, on a thread of the session, until it or its session is
  /// disposed.</summary>
  public sealed class Listener : IDisposable {
    private static readonly Native.MessageCallback Received = (user, message) => {
      var listener = Callbacks.Target<Listener>(user);
      listener.session.Run(listener.what, () => {
        using (Message kept = Message.Keep(message)) listener.received(kept);
      });
    };

    private readonly Session session;
    private readonly string what;
    private readonly Action<Message> received;
    private readonly SubscriptionHandle handle;

    internal Listener(Session session, SessionHandle opened, string channel, SubscribeOptions options,
      Schema schema, Action<Message> received) {
      this.session = session;
      this.received = received ?? throw new ArgumentNullException(nameof(received));
      what = "The callback of channel \"" + channel + "\"";
      Native.SubscribeOptions chosen = (options ?? new SubscribeOptions()).ForLibrary(schema);
      SubscriptionHandle made = null;
      Callbacks.Give(this, user => Native.hgros_subscribe(opened, Texts.Uncut(channel), ref chosen, Received,
        user, Callbacks.Release, out made));
      handle = made;
      GC.KeepAlive(schema);
    }

    /// <summary>Counts since the subscription began.</summary>
    public SubscriptionStats Stats => SubscriptionStats.Of(handle);

    /// <summary>No call comes after it. Outside callbacks it waits for the running one.</summary>
    public void Dispose() {
      session.Forget(this);
      handle.Dispose();
    }
  }

  public sealed partial class Session {
    /// <summary>Calls a function with each message of a channel of any type, or of that in the options. The message
    /// is disposed when the function returns; Keep keeps it longer.</summary>
    public Listener ListenRaw(string channel, Action<Message> received, SubscribeOptions options = null) =>
      Keep(new Listener(this, handle, channel, options, options?.Schema, received));

    /// <summary>Calls a function with each message of a channel of a class.</summary>
    public Listener Listen<T>(string channel, MessageType<T> type, Action<T> received,
      SubscribeOptions options = null) {
      Arguments.Given(type, nameof(type));
      Arguments.Given(received, nameof(received));
      return Keep(
        new Listener(this, handle, channel, options, type.Schema, message => received(message.Read(type))));
    }
  }
}
