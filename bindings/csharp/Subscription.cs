using System;
using System.Collections.Generic;
using System.Threading;
using System.Threading.Tasks;

namespace Hgros {
  /// <summary>Which thread runs a callback.</summary>
  public enum Executor {
    /// <summary>Worker threads of the session: for callbacks of any length.</summary>
    Workers,
    /// <summary>The thread that delivers: lowest latency; keep the callback short.</summary>
    Inline,
    /// <summary>A thread of its own.</summary>
    Dedicated
  }

  /// <summary>Read when a subscription begins. The default is the 16 newest messages.</summary>
  public sealed class SubscribeOptions {
    /// <summary>For logs, tables and configuration; null: channel and number.</summary>
    public string Name { get; set; }
    /// <summary>The expected type; null: any. A subscription of a class sets it.</summary>
    public Schema Schema { get; set; }
    /// <summary>Newest messages that may wait, older ones are dropped and counted; 0: 16.</summary>
    public int KeepLast { get; set; }
    /// <summary>Not 0: lossless, with room for this many. Publishers get Code.Full meanwhile.</summary>
    public int KeepAll { get; set; }
    /// <summary>For KeepAll: also at most about this many bytes; 0: no limit.</summary>
    public long KeepAllBytes { get; set; }
    /// <summary>A callback may run any number of times at once; otherwise one by one, in order.</summary>
    public bool Concurrent { get; set; }
    /// <summary>Which thread runs a callback; not for queues.</summary>
    public Executor Executor { get; set; }

    internal Native.SubscribeOptions ForLibrary(Schema type) {
      return new Native.SubscribeOptions {
        Size = Native.SizeOf<Native.SubscribeOptions>(), Name = Texts.Uncut(Name),
        Schema = type == null ? IntPtr.Zero : type.Handle.DangerousGetHandle(),
        KeepLast = Arguments.Count(KeepLast, nameof(KeepLast)),
        KeepAll = Arguments.Count(KeepAll, nameof(KeepAll)),
        KeepAllBytes = Arguments.Count(KeepAllBytes, nameof(KeepAllBytes)), Concurrent = Concurrent ? 1 : 0,
        Executor = (int)Executor
      };
    }
  }

  /// <summary>Counts since a subscription began.</summary>
  public struct SubscriptionStats {
    /// <summary>Messages that reached it, including those dropped later.</summary>
    public ulong Received { get; internal set; }
    /// <summary>Removed from a full keep-last queue.</summary>
    public ulong Dropped { get; internal set; }
    /// <summary>Messages that were taken, or callbacks that returned.</summary>
    public ulong Taken { get; internal set; }
    /// <summary>Waiting now.</summary>
    public ulong Queued { get; internal set; }
    /// <summary>Not delivered: of another type.</summary>
    public ulong Mismatched { get; internal set; }

    internal static SubscriptionStats Of(SubscriptionHandle handle) {
      var stats = new Native.SubscriptionStats { Size = Native.SizeOf<Native.SubscriptionStats>() };
      HgrosException.Check(Native.hgros_subscription_get_stats(handle, ref stats));
      return new SubscriptionStats {
        Received = stats.Received, Dropped = stats.Dropped, Taken = stats.Run, Queued = stats.Queued,
        Mismatched = stats.Mismatched
      };
    }
  }

  /// <summary>A queue of received messages. Once it or its session has ended, waits and calls throw HgrosException
  /// with Code.Closed, or ObjectDisposedException.</summary>
  public sealed class RawSubscription : IDisposable {
    private const int TimedOut = (int)Code.TimedOut;

    private readonly SubscriptionHandle handle;
    private readonly Session session; // Not forgotten while its queue is used.

    internal RawSubscription(Session session, SubscriptionHandle handle) {
      this.session = session;
      this.handle = handle;
    }

    /// <summary>Takes the oldest message, which the caller disposes. False if none comes in time; without a timeout
    /// it does not wait.</summary>
    public bool TryTake(out Message message, TimeSpan timeout = default) {
      IntPtr taken;
      int status = Native.hgros_queue_take(handle, Waiting.Nanoseconds(timeout), out taken);
      if (status != 0 && status != TimedOut) throw HgrosException.Last(status);
      message = status == 0 ? new Message(taken) : null;
      return status == 0;
    }

    /// <summary>Waits for the oldest message, which the caller disposes. Each message goes to one caller.</summary>
    public Message Take(CancellationToken token = default) {
      Message message;
      if (token.CanBeCanceled) return TakeAsync(token).GetAwaiter().GetResult();
      TryTake(out message, Timeout.InfiniteTimeSpan);
      return message;
    }

    /// <summary>The same without a thread that waits.</summary>
    public async Task<Message> TakeAsync(CancellationToken token = default) {
      Message message;
      token.ThrowIfCancellationRequested();
      while (!TryTake(out message)) await Readiness.Wait(handle, token).ConfigureAwait(false);
      return message;
    }

    /// <summary>Counts since the subscription began.</summary>
    public SubscriptionStats Stats => SubscriptionStats.Of(handle);

    /// <summary>Ends the subscription and wakes those that wait for a message.</summary>
    public void Dispose() {
      try {
        Native.hgros_subscription_end(handle);
      } catch (ObjectDisposedException) {
        return;
      }
      handle.Dispose();
      GC.KeepAlive(session);
    }
  }

  /// <summary>A queue of received messages of a class.</summary>
  public sealed class Subscription<T> : IDisposable {
    private readonly MessageType<T> type;

    /// <summary>The queue, which gives the bytes and the MessageInfo of messages instead.</summary>
    public RawSubscription Raw { get; }

    internal Subscription(RawSubscription raw, MessageType<T> type) {
      Raw = raw;
      this.type = type;
    }

    private T Read(Message message) {
      using (message) return message.Read(type);
    }

    /// <summary>Takes the oldest message. False if none comes in time; without a timeout it does not wait.</summary>
    public bool TryNext(out T next, TimeSpan timeout = default) {
      Message message;
      bool taken = Raw.TryTake(out message, timeout);
      next = taken ? Read(message) : default;
      return taken;
    }

    /// <summary>Waits for the oldest message. Each message goes to one caller.</summary>
    public T Next(CancellationToken token = default) => Read(Raw.Take(token));

    /// <summary>The same without a thread that waits.</summary>
    public async Task<T> NextAsync(CancellationToken token = default) =>
      Read(await Raw.TakeAsync(token).ConfigureAwait(false));

    /// <summary>All messages until the subscription or its session ends.</summary>
    public IEnumerable<T> All(CancellationToken token = default) {
      while (true) {
        Message message;
        try {
          message = Raw.Take(token);
        } catch (HgrosException exception) when (exception.Code == Code.Closed) {
          yield break;
        } catch (ObjectDisposedException) {
          yield break;
        }
        yield return Read(message);
      }
    }

    /// <summary>Counts since the subscription began.</summary>
    public SubscriptionStats Stats => Raw.Stats;

    /// <summary>Ends the subscription and wakes those that wait for a message.</summary>
    public void Dispose() => Raw.Dispose();
  }

  public sealed partial class Session {
    /// <summary>Receives a channel of any type, or of that in the options, as bytes.</summary>
    public RawSubscription SubscribeRaw(string channel, SubscribeOptions options = null) =>
      SubscribeAs(channel, options, options?.Schema);

    /// <summary>Receives a channel as a class. Messages of another type are counted, not delivered.</summary>
    public Subscription<T> Subscribe<T>(string channel, MessageType<T> type, SubscribeOptions options = null) =>
      new Subscription<T>(SubscribeAs(channel, options, Arguments.Given(type, nameof(type)).Schema), type);

    private RawSubscription SubscribeAs(string channel, SubscribeOptions options, Schema schema) {
      Native.SubscribeOptions chosen = (options ?? new SubscribeOptions()).ForLibrary(schema);
      SubscriptionHandle queue;
      HgrosException.Check(Native.hgros_subscribe_queue(handle, Texts.Uncut(channel), ref chosen, out queue));
      GC.KeepAlive(schema);
      return new RawSubscription(this, queue);
    }
  }
}
