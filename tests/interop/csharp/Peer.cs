using System;
using System.IO;
using System.Linq;
using System.Threading;
using Hgros;

// The peer of C#, which talks to those of other languages: Peer.exe ROLE [ARGUMENT...]. One session, whose YAML is in
// HGROS_INTEROP_YAML.
internal static class Peer {
  private static readonly TimeSpan Patience = TimeSpan.FromSeconds(30);
  private static readonly DynamicType Log = DynamicType.Known("foxglove.Log");
  private static readonly DynamicType Cloud = DynamicType.Known("foxglove.PointCloud");

  private static int Main(string[] arguments) {
    try {
      using (var session = new Session(Environment.GetEnvironmentVariable("HGROS_INTEROP_YAML")))
        Play(session, arguments[0], arguments.Skip(1).ToArray());
      return 0;
    } catch (Exception failure) {
      Console.Error.WriteLine(failure.Message);
      return 1;
    }
  }

  private static void Play(Session session, string role, string[] words) {
    switch (role) {
      case "publish": Publish(session, words[0], int.Parse(words[1])); break;
      case "subscribe": Subscribe(session, words[0], int.Parse(words[1])); break;
      case "latch": Latch(session, words[0], words[1]); break;
      case "bulk-publish": BulkPublish(session, words[0], int.Parse(words[1])); break;
      case "bulk-subscribe": BulkSubscribe(session, words[0], int.Parse(words[1])); break;
      case "serve": Serve(session, words[0]); break;
      case "call": Call(session, words[0], words[1]); break;
      case "misfit": Misfit(session, words[0]); break;
      default: throw new ArgumentException("There is no role \"" + role + "\".");
    }
  }

  private static DynamicMessage Say(string text) => new DynamicMessage(Log) { ["message"] = text };

  private static string Said(DynamicMessage log) => (string)log["message"];

  private static void UntilStdinIsClosed() => Console.In.ReadToEnd();

  // Takes steps in a thread, `most` or until stdin is closed, and then writes how many.
  private static void Repeat(Session session, int most, Action<int> step, Func<int, string> last) {
    var thread = new Thread(() => {
      int count = 0;
      try {
        for (; count < most; ++count) step(count + 1);
      } catch (HgrosException failure) when (failure.Code == Code.Closed) {}
      Console.WriteLine(last(count));
    });
    thread.Start();
    UntilStdinIsClosed();
    session.End();
    thread.Join();
  }

  private static void Publish(Session session, string channel, int count) {
    using (var publisher = session.Advertise(channel, Log)) {
      session.WaitForSubscribers(channel, 1, Patience);
      Repeat(session, count, i => {
        publisher.PublishWait(Say(i.ToString()));
        if (i == 1) Console.WriteLine("publishing");
      }, sent => "published " + sent);
    }
  }

  private static void Subscribe(Session session, string channel, int count) {
    string first = null, last = null;
    using (var queue = session.Subscribe(channel, Log, new SubscribeOptions { KeepAll = 100 }))
      Repeat(session, count, i => {
        last = Said(queue.Next());
        if (i == 1) Console.WriteLine("receiving " + (first = last));
        if (first == "1" && last != i.ToString())
          throw new InvalidDataException("\"" + last + "\" came instead of \"" + i + "\".");
      }, received => "received " + received + " " + last);
  }

  private static void Latch(Session session, string channel, string text) {
    using (var publisher = session.Advertise(channel, Log, latched: 2)) {
      foreach (string one in new[] { "old", text, "new" }) publisher.Publish(Say(one));
      Console.WriteLine("latched");
      UntilStdinIsClosed();
    }
  }

  private static byte ByteAt(int i) => (byte)(i * 7 + 3);

  private static void BulkPublish(Session session, string channel, int size) {
    using (var publisher = session.AdvertiseRaw(channel, Cloud.Schema)) {
      session.WaitForSubscribers(channel, 1, Patience);
      // foxglove.PointCloud in protobuf, with the large field last: it is written where the receiver reads it.
      var head = new MemoryStream();
      byte[] stride = { 4 << 3 | 5, 1, 0, 0, 0 };
      head.Write(stride, 0, stride.Length);
      head.WriteByte(6 << 3 | 2);
      for (int rest = size; ; rest >>= 7) {
        head.WriteByte((byte)(rest > 127 ? rest | 128 : rest));
        if (rest < 128) break;
      }
      using (Loan loan = publisher.Lend(head.Length + size))
      using (Stream stream = loan.OpenWrite()) {
        head.WriteTo(stream);
        byte[] data = Enumerable.Range(0, size).Select(ByteAt).ToArray();
        stream.Write(data, 0, size);
        loan.Publish(Patience);
      }
      Console.WriteLine("published " + size);
      UntilStdinIsClosed();
    }
  }

  private static void BulkSubscribe(Session session, string channel, int size) {
    using (var queue = session.Subscribe(channel, Cloud)) {
      Console.WriteLine("subscribed");
      DynamicMessage cloud;
      if (!queue.TryNext(out cloud, Patience)) throw new TimeoutException("No cloud came within 30 s.");
      var data = (byte[])cloud["data"];
      if (data.Length != size) throw new InvalidDataException(data.Length + " bytes came instead of " + size + ".");
      if (!data.SequenceEqual(Enumerable.Range(0, size).Select(ByteAt)))
        throw new InvalidDataException("Other bytes came.");
      Console.WriteLine("received " + size);
    }
  }

  private static void Serve(Session session, string name) {
    using (session.Serve(name, Log, Log, Answer)) {
      Console.WriteLine("serving");
      UntilStdinIsClosed();
    }
  }

  private static DynamicMessage Answer(DynamicMessage request) {
    if (Said(request) == "fail") throw new InvalidOperationException("asked to fail");
    return Say("re: " + Said(request));
  }

  // A server that is not known yet is waited for.
  private static void Call(Session session, string name, string text) {
    for (DateTime end = DateTime.UtcNow + Patience; ; Thread.Sleep(20)) {
      try {
        Console.WriteLine("answer " + Said(session.Call(name, Log, Log, Say(text), Patience)));
        return;
      } catch (HgrosException failure) when (failure.Code != Code.NoServer || DateTime.UtcNow > end) {
        Console.WriteLine("failed " + failure.Sentence);
        return;
      } catch (HgrosException) {}
    }
  }

  private static void Misfit(Session session, string channel) {
    using (session.Subscribe(channel, DynamicType.Known("foxglove.PoseInFrame"))) {
      Console.WriteLine("subscribed");
      UntilStdinIsClosed();
    }
  }
}
