using System;
using System.Threading;
using System.Threading.Tasks;
using System.Runtime.InteropServices;

namespace Hgros {
  /// <summary>Read when a service is offered.</summary>
  public sealed class ServeOptions {
    /// <summary>Of the node, for logs and configuration; null: the service's.</summary>
    public string Name { get; set; }
    /// <summary>Requests that may wait; further ones fail with Code.Full. 0: 16384.</summary>
    public int MostWaiting { get; set; }
    /// <summary>Any number of requests may be handled at once.</summary>
    public bool Concurrent { get; set; }
    /// <summary>Which thread runs the handler.</summary>
    public Executor Executor { get; set; }
  }

  /// <summary>Offers a service until it or its session is disposed.</summary>
  public sealed class Service : IDisposable {
    // What a handler throws is for its caller, so it is neither logged nor counted here.
    private static readonly Native.ServiceHandler Requested = (user, request, reply) =>
      Callbacks.Run(() => {
        byte[] answer = Callbacks.Target<Service>(user).handler(request);
        HgrosException.Check(Native.hgros_reply_set(reply, answer, (UIntPtr)(ulong)answer.LongLength));
      }, exception => {
        var refused = exception as HgrosException;
        string sentence = Texts.Mended(refused?.Sentence ?? exception.Message);
        HgrosException.Check(Native.hgros_reply_fail(reply, sentence));
      });

    private readonly Session session;
    private readonly Func<IntPtr, byte[]> handler;
    private readonly ServiceHandle handle;

    internal Service(Session session, SessionHandle opened, string name, Schema request, Schema reply,
      ServeOptions options, Func<IntPtr, byte[]> handler) {
      this.session = session;
      this.handler = handler;
      var chosen = new Native.ServeOptions {
        Size = Native.SizeOf<Native.ServeOptions>(), Name = Texts.Uncut(options?.Name),
        MostWaiting = Arguments.Count(options?.MostWaiting ?? 0, nameof(options.MostWaiting)),
        Concurrent = options != null && options.Concurrent ? 1 : 0,
        Executor = (int)(options?.Executor ?? Executor.Workers)
      };
      ServiceHandle made = null;
      Callbacks.Give(this, user => Native.hgros_serve(opened, Texts.Uncut(name), request.Handle, reply.Handle,
        ref chosen, Requested, user, Callbacks.Release, out made));
      handle = made;
    }

    /// <summary>Withdraws the service: requests that wait fail. Outside callbacks it waits for running handlers.
    /// </summary>
    public void Dispose() {
      session.Forget(this);
      handle.Dispose();
    }
  }

  public sealed partial class Session {
    private static readonly Native.ReplyCallback Replied = (user, status, sentence, reply) =>
      Callbacks.Run(() => Callbacks.Target<Action<int, string, IntPtr>>(user)(status,
        Marshal.PtrToStringAnsi(sentence), reply),
        exception => Console.Error.WriteLine("hgros: a reply was lost: " + exception));

    /// <summary>Offers a service. The handler runs on a thread of the session. What it throws becomes the caller's
    /// Code.HandlerFailed with the same sentence.</summary>
    public Service Serve<TRequest, TReply>(string name, MessageType<TRequest> request, MessageType<TReply> reply,
      Func<TRequest, TReply> handler, ServeOptions options = null) {
      Arguments.Given(request, nameof(request));
      Arguments.Given(reply, nameof(reply));
      Arguments.Given(handler, nameof(handler));
      return Keep(new Service(this, handle, name, request.Schema, reply.Schema, options,
        message => reply.Write(handler(ReadFrom(message, request)))));
    }

    /// <summary>Calls a service and waits for its reply. Inside a callback, requests of this session are handled
    /// meanwhile.</summary>
    public TReply Call<TRequest, TReply>(string name, MessageType<TRequest> requestType,
      MessageType<TReply> replyType, TRequest request, TimeSpan? timeout = null) {
      byte[] data = Arguments.Given(requestType, nameof(requestType)).Write(request);
      Arguments.Given(replyType, nameof(replyType));
      IntPtr reply;
      HgrosException.Check(Native.hgros_call(handle, Texts.Uncut(name), requestType.Schema.Handle, data,
        (UIntPtr)(ulong)data.LongLength, replyType.Schema.Handle, Waiting.Nanoseconds(timeout), out reply));
      using (var message = new Message(reply)) return message.Read(replyType);
    }

    /// <summary>Calls a service without a thread that waits. The token cancels the call.</summary>
    public async Task<TReply> CallAsync<TRequest, TReply>(string name, MessageType<TRequest> requestType,
      MessageType<TReply> replyType, TRequest request, TimeSpan? timeout = null,
      CancellationToken token = default) {
      token.ThrowIfCancellationRequested();
      byte[] data = Arguments.Given(requestType, nameof(requestType)).Write(request);
      Arguments.Given(replyType, nameof(replyType));
      var ended = new TaskCompletionSource<TReply>(TaskCreationOptions.RunContinuationsAsynchronously);
      Action<int, string, IntPtr> replied = (status, sentence, reply) => {
        if (status == (int)Code.Cancelled && token.IsCancellationRequested) ended.TrySetCanceled(token);
        else if (status != 0) ended.TrySetException(new HgrosException((Code)status, sentence));
        else Settle(ended, reply, replyType);
      };
      PendingCallHandle call = null;
      Callbacks.Give(replied, user => Native.hgros_call_later(handle, Texts.Uncut(name), requestType.Schema.Handle,
        data, (UIntPtr)(ulong)data.LongLength, replyType.Schema.Handle, Waiting.Nanoseconds(timeout), Replied, user,
        Callbacks.Release, out call));
      using (call)
      using (token.Register(() => Native.hgros_call_cancel(call)))
        return await ended.Task.ConfigureAwait(false);
    }

    private static void Settle<TReply>(TaskCompletionSource<TReply> ended, IntPtr reply, MessageType<TReply> type) {
      try {
        ended.TrySetResult(ReadFrom(reply, type));
      } catch (Exception exception) {
        ended.TrySetException(exception);
      }
    }

    // Reads a message of the library within a callback.
    private static T ReadFrom<T>(IntPtr message, MessageType<T> type) {
      UIntPtr size;
      IntPtr data = Native.hgros_message_data(message, out size);
      return type.Read(data, (long)size);
    }
  }
}
