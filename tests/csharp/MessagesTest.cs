using System;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Runtime.InteropServices;
using System.Threading;
using Hgros;
using static Test;

// Messages of classes and of bytes, from session to session.
public static class MessagesTest {
  private static readonly DynamicType Log = DynamicType.Known("foxglove.Log");

  private static DynamicMessage Say(object text) => new DynamicMessage(Log) { ["message"] = text.ToString() };

  private static string Said(DynamicMessage log) => (string)log["message"];

  [Test]
  public static void TypedMessagesGoFromSessionToSession() {
    using (var from = new Session())
    using (var to = new Session())
    using (var queue = to.Subscribe("wörds", Log, new SubscribeOptions { KeepAll = 10 }))
    using (var publisher = from.Advertise("wörds", Log)) {
      from.WaitForSubscribers("wörds", 1, Patience);
      to.WaitForPublishers("wörds", 1, Patience);
      CancellationToken patient = new CancellationTokenSource(Patience).Token;
      publisher.PublishWait(Say("ä"), Patience);
      Equal("ä", Said(queue.Next(patient)));
      Thread sender = Run(() => {
        for (int i = 1; i <= 1000; ++i) publisher.PublishWait(Say(i), Patience);
      });
      int next = 1;
      foreach (DynamicMessage log in queue.All(patient)) {
        Equal(next.ToString(), Said(log));
        if (++next > 1000) break;
      }
      Soon(sender);
      Equal(0UL, queue.Stats.Dropped);
      publisher.Publish(Say("last"));
      Message message;
      True(queue.Raw.TryTake(out message, Patience), "the last one comes");
      using (message) {
        MessageInfo info = message.Info;
        True(info.Remote && info.Key != 0 && info.PublishTime > 0, "the message has an origin");
        Equal(from.Id, info.Publisher);
      }
    }
  }

  [Test]
  public static void OtherTypesAreRefusedWithBothNames() {
    var lines = new ConcurrentQueue<string>();
    var logged = new SessionOptions { Log = (level, line) => lines.Enqueue(line) };
    var pose = DynamicType.Known("foxglove.PoseInFrame");
    using (var from = new Session())
    using (var to = new Session("", logged))
    using (var publisher = from.Advertise("words", Log, latched: 1))
    using (var queue = to.Subscribe("words", pose)) {
      publisher.Publish(Say("hello"));
      Until("the log names both types",
        () => lines.Any(line => line.Contains("foxglove.Log") && line.Contains("foxglove.PoseInFrame")));
      DynamicMessage none;
      True(!queue.TryNext(out none), "no message is delivered");
      Contains("foxglove.PoseInFrame", Fails(Code.TypeMismatch, () => to.Advertise("words", Log)));
      using (var raw = from.SubscribeRaw("words"))
      using (Message message = Soon(raw.TakeAsync())) {
        Equal("message: hello", message.Decode().ToString());
        Contains("foxglove.Log", Fails(Code.TypeMismatch, () => message.Read(pose)));
      }
    }
  }

  [Test]
  public static void BytesAreLentUntilTheMessageIsDisposed() {
    using (var session = new Session())
    using (var queue = session.SubscribeRaw("bytes"))
    using (var publisher = session.AdvertiseRaw("bytes", Schema.Raw("my.bytes"))) {
      ulong before = Message.Leases;
      publisher.Publish(new byte[] { 1, 2, 3 });
      publisher.Publish(new byte[0]);
      Message first = queue.Take(), second = queue.Take();
      UnmanagedMemoryStream stream = first.OpenRead();
      Equal(before + 2, Message.Leases);
      Equal("1 2 3", string.Join(" ", first.ToArray()));
      Equal(2, Marshal.ReadByte(first.Data, 1) + 0);
      Equal(1, stream.ReadByte());
      Equal(0L, second.Size);
      Equal(-1, second.OpenRead().ReadByte());
      Equal("my.bytes", first.Schema.TypeName);
      Fails(Code.NotFound, () => first.Decode());
      Message kept = first.Keep();
      first.Dispose();
      first.Dispose();
      Throws<ObjectDisposedException>(() => stream.ReadByte());
      Throws<ObjectDisposedException>(() => first.ToArray());
      Equal(3L, kept.Size);
      kept.Dispose();
      second.Dispose();
      Equal(before, Message.Leases);
    }
  }

  [Test]
  public static void ForgottenMessagesGiveTheirLeaseBack() {
    using (var session = new Session())
    using (var queue = session.Subscribe("words", Log))
    using (var publisher = session.Advertise("words", Log)) {
      ulong before = Message.Leases;
      publisher.Publish(Say("hello"));
      Soon(Run(() => queue.Raw.Take())); // On a stack that does not stay.
      Until("the garbage collector disposes it", () => {
        GC.Collect();
        GC.WaitForPendingFinalizers();
        return Message.Leases == before;
      });
    }
  }

  [Test]
  public static void QueuesDropOrHoldBack() {
    using (var session = new Session())
    using (var newest = session.Subscribe("newest", Log, new SubscribeOptions { KeepLast = 2 }))
    using (var every = session.Subscribe("every", Log, new SubscribeOptions { KeepAll = 2 }))
    using (var dropping = session.Advertise("newest", Log))
    using (var lossless = session.Advertise("every", Log)) {
      for (int i = 0; i < 5; ++i) dropping.Publish(Say(i));
      Equal(3UL, newest.Stats.Dropped);
      Equal("3", Said(newest.Next()));
      lossless.Publish(Say(1));
      lossless.Publish(Say(2));
      Fails(Code.Full, () => lossless.Publish(Say(3)));
      Fails(Code.TimedOut, () => lossless.PublishWait(Say(3), TimeSpan.FromMilliseconds(10)));
      var cancel = new CancellationTokenSource();
      Thread waiting = Run(() => Throws<OperationCanceledException>(
        () => lossless.PublishWait(Say(3), null, cancel.Token)));
      cancel.Cancel();
      Soon(waiting);
      every.Next();
      lossless.PublishWait(Say(3), Patience);
      Equal(2UL, every.Stats.Queued);
    }
  }

  [Test]
  public static void FourMegabytesGoInALoan() {
    const int size = 4 << 20;
    using (var from = new Session())
    using (var to = new Session())
    using (var queue = to.SubscribeRaw("big"))
    using (var publisher = from.AdvertiseRaw("big", Schema.Raw("my.bytes"))) {
      from.WaitForSubscribers("big", 1, Patience);
      Loan loan = publisher.Lend(size);
      UnmanagedMemoryStream stream = loan.OpenWrite();
      var chunk = Enumerable.Range(0, 4096).Select(i => (byte)i).ToArray();
      for (int i = 0; i < size; i += chunk.Length) stream.Write(chunk, 0, chunk.Length);
      loan.Publish(Patience);
      Throws<ObjectDisposedException>(() => stream.Seek(0, SeekOrigin.Begin).Equals(stream.ReadByte()));
      Throws<ObjectDisposedException>(() => loan.Data.ToInt64());
      using (Message message = Soon(queue.TakeAsync())) {
        Equal((long)size, message.Size);
        byte[] copy = message.ToArray();
        True(Enumerable.Range(0, size).All(i => copy[i] == (byte)i), "all bytes arrive");
      }
      publisher.Lend(10).Dispose();
    }
  }

  [Test]
  public static void CallbacksGetMessagesAndTheirExceptionsAreReported() {
    var lines = new ConcurrentQueue<string>();
    using (var session = new Session("", new SessionOptions { Log = (level, line) => lines.Enqueue(level + line) }))
    using (var publisher = session.Advertise("words", Log)) {
      var heard = new BlockingCollection<string>();
      Message kept = null;
      using (session.Listen("words", Log, log => {
        if (Said(log) == "bad") throw new InvalidOperationException("a mouse");
        heard.Add(Said(log));
      }, new SubscribeOptions { KeepAll = 10 }))
      using (session.ListenRaw("words", message => kept = kept ?? message.Keep(),
        new SubscribeOptions { Executor = Executor.Inline })) {
        foreach (string word in new[] { "one", "bad", "two" }) publisher.PublishWait(Say(word), Patience);
        string next;
        foreach (string word in new[] { "one", "two" }) {
          True(heard.TryTake(out next, Patience), "a message comes");
          Equal(word, next);
        }
      }
      Equal(1L, session.FailedCallbacks);
      Until("the log has the exception", () => lines.Any(line => line.StartsWith("Error") && line.Contains("a mouse")));
      Equal("one", Said(kept.Read(Log)));
      kept.Dispose();
      publisher.Publish(Say("three"));
      Equal(0, heard.Count);
    }
  }
}
