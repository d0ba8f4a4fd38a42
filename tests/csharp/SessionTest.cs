using System;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Hgros;
using static Test;

// Sessions: their ends, errors, peers and log.
public static class SessionTest {
  private static readonly DynamicType Log = DynamicType.Known("foxglove.Log");

  [Test]
  public static void WhatWaitsIsWoken() {
    var session = new Session();
    RawSubscription ended = session.SubscribeRaw("a"), disposed = session.SubscribeRaw("b");
    var cancel = new CancellationTokenSource();
    Task<Message> cancelled = ended.TakeAsync(cancel.Token);
    cancel.Cancel();
    Throws<OperationCanceledException>(() => Soon(cancelled));
    Throws<OperationCanceledException>(() => ended.Take(cancel.Token));

    Task<Message> waiting = disposed.TakeAsync();
    Exception thrown = null;
    Thread blocked = Run(() => thrown = Throws<Exception>(() => disposed.Take()));
    disposed.Dispose();
    Soon(blocked);
    foreach (Exception failure in new[] { thrown, Throws<Exception>(() => Soon(waiting)) }) {  // The second form: too late.
      True((failure as HgrosException)?.Code == Code.Closed || failure is ObjectDisposedException, "it is closed");
    }
    Throws<ObjectDisposedException>(() => disposed.Take());

    waiting = ended.TakeAsync();
    blocked = Run(() => Fails(Code.Closed, () => ended.Take()));
    session.End();
    Fails(Code.Closed, () => Soon(waiting));
    Soon(blocked);
    session.Dispose();
    session.Dispose();
    Throws<ObjectDisposedException>(() => session.SubscribeRaw("c"));
    Throws<ObjectDisposedException>(() => session.Log(LogLevel.Info, "hello"));
    Fails(Code.Closed, () => ended.Take());
    ended.Dispose();
  }

  [Test]
  public static void ExceptionsNameTheArgument() {
    using (var session = new Session())
    using (RawPublisher publisher = session.AdvertiseRaw("a", Schema.Raw("A"))) {
      var count = Throws<ArgumentOutOfRangeException>(
        () => session.SubscribeRaw("a", new SubscribeOptions { KeepLast = -1 }));
      Equal("KeepLast", count.ParamName);
      Equal(-1L, count.ActualValue);
      Equal("latched", Throws<ArgumentOutOfRangeException>(() => session.Advertise("b", Log, latched: -1)).ParamName);
      Equal("type", Throws<ArgumentNullException>(() => session.Advertise<DynamicMessage>("b", null)).ParamName);
      Equal("type", Throws<ArgumentNullException>(() => session.Subscribe<DynamicMessage>("b", null)).ParamName);
      Equal("schema", Throws<ArgumentNullException>(() => session.AdvertiseRaw("b", null)).ParamName);
      Equal("data", Throws<ArgumentNullException>(() => publisher.Publish(null)).ParamName);
      Equal("data", Throws<ArgumentNullException>(() => publisher.PublishWait(null)).ParamName);
      Equal("requestType",
        Throws<ArgumentNullException>(() => session.Call<DynamicMessage, DynamicMessage>("c", null, Log, null)).ParamName);
    }
  }

  [Test]
  public static void ManyTasksWaitWithOneThread() {
    using (var session = new Session())
    using (var publisher = session.Advertise("go", Log)) {
      var queues = Enumerable.Range(0, 100).Select(i => session.Subscribe("go", Log)).ToList();
      var texts = queues.Select(queue => queue.NextAsync()).ToArray();
      Until("threads are few", () => Threads() < 60);  // Those of tests before end.
      publisher.Publish(new DynamicMessage(Log) { ["message"] = "all" });
      Equal(100, Soon(Task.WhenAll(texts)).Count(log => (string)log["message"] == "all"));
    }
  }

  private static int Threads() => Directory.GetDirectories("/proc/self/task").Length;

  [Test]
  public static void EndsInEveryCallback() {
    var session = new Session();
    var gone = new ManualResetEventSlim();
    Listener listener = null;
    Transforms transforms = session.OpenTransforms();
    Params parameters = session.OpenParams();
    var publisher = session.Advertise("stop", Log);
    var ready = new ManualResetEventSlim();
    listener = session.Listen("stop", Log, log => {
      ready.Wait(Patience);
      listener.Dispose();
      transforms.Dispose();
      parameters.Dispose();
      session.Dispose();
      gone.Set();
    });
    ready.Set();
    publisher.Publish(new DynamicMessage(Log));
    True(gone.Wait(Patience), "the callback returns");
    session.Dispose(); // Waits until it is closed.
    Throws<ObjectDisposedException>(() => session.End());
    Throws<ObjectDisposedException>(() => transforms.Lookup("a", "b"));
    Fails(Code.Closed, () => publisher.Publish(new DynamicMessage(Log)));
  }

  [Test]
  public static void ClosesWhileOthersUseIt() {
    for (int round = 0; round < 20; ++round) {
      var session = new Session();
      var publisher = session.Advertise("words", Log);
      var queue = session.Subscribe("words", Log, new SubscribeOptions { KeepAll = 1 });
      var users = Enumerable.Range(0, 4).Select(i => Run(() => {
        try {
          while (true) {
            if (i % 2 == 0) publisher.PublishWait(new DynamicMessage(Log));
            else if (i == 1) queue.Next();
            else queue.NextAsync().Wait();
          }
        } catch (ObjectDisposedException) {
        } catch (HgrosException failure) when (failure.Code == Code.Closed) {
        } catch (AggregateException failure) when (failure.InnerException is ObjectDisposedException ||
          (failure.InnerException as HgrosException)?.Code == Code.Closed) {}
      })).ToList();
      Until("messages come", () => queue.Stats.Taken > 10);
      if (round % 2 == 0) queue.Dispose();
      session.Dispose();
      users.ForEach(Soon);
      publisher.Dispose();
      queue.Dispose();
    }
  }

  [Test]
  public static void ForgottenCallbacksLiveAsLongAsTheirSession() {
    const int count = 20;
    var heard = new CountdownEvent(count);
    WeakReference queue = null;
    WeakReference[] listeners = null;
    var session = new Session();
    Soon(Run(() => {
      queue = new WeakReference(session.Subscribe("words", Log));
      listeners = Enumerable.Range(0, count)
        .Select(i => new WeakReference(session.Listen("words", Log, log => heard.Signal()))).ToArray();
    }));
    Until("a forgotten queue is collected", () => Collected(new[] { queue }) == 1);
    using (var publisher = session.Advertise("words", Log)) publisher.Publish(new DynamicMessage(Log));
    True(heard.Wait(Patience), "forgotten callbacks are called");
    session.Dispose();
    // Old values on the stacks of threads may keep some.
    Until("most are collected after their session", () => Collected(listeners) > count / 2);
  }

  [Test]
  public static void CallbacksThatADisposedSessionRefusesAreCollected() {
    const int count = 20;
    WeakReference[] targets = null;
    Soon(Run(() => {
      var session = new Session();
      Params parameters = session.OpenParams();
      parameters.Dispose();
      session.Dispose();
      targets = Enumerable.Range(0, count).Select(i => Refused(session, parameters)).ToArray();
    }));
    // Old values on the stacks of threads may keep some.
    Until("most are collected", () => Collected(targets) > count / 2);
  }

  // What the callbacks have that a disposed session and its parameters refuse.
  private static WeakReference Refused(Session session, Params parameters) {
    var target = new object();
    Throws<ObjectDisposedException>(() => session.Listen("words", Log, message => target.ToString()));
    Throws<ObjectDisposedException>(() => session.Serve("words", Log, Log, message => (DynamicMessage)target));
    Throws<ObjectDisposedException>(() => session.OnPeer((happened, peer, channel, reason) => target.ToString()));
    Throws<ObjectDisposedException>(() => parameters.OnChange("", (path, yaml) => target.ToString()));
    return new WeakReference(target);
  }

  private static int Collected(WeakReference[] references) {
    GC.Collect();
    GC.WaitForPendingFinalizers();
    return references.Count(reference => !reference.IsAlive);
  }

  [Test]
  public static void ErrorsHaveACodeAndASentence() {
    Contains("sesion", Fails(Code.ConfigError, () => new Session("sesion: {}")));
    Contains("/no/such.yaml", Fails(Code.ConfigError, () => Session.FromFiles(new[] { "/no/such.yaml" })));
    Fails(Code.NotFound, () => Schema.Known("no.Such"));
    Fails(Code.Failed, () => Schema.Protobuf("no.Such", new byte[] { 1, 2, 3 }));
    Throws<ArgumentOutOfRangeException>(() => Raw(TimeSpan.FromSeconds(-5)));
    using (var session = new Session()) {
      Fails(Code.InvalidArgument, () => session.SubscribeRaw(null));
      Fails(Code.Failed, () => session.SubscribeRaw("no name\n"));
      Fails(Code.TimedOut, () => Raw(TimeSpan.Zero, session));
    }
  }

  private static void Raw(TimeSpan timeout, Session session = null) {
    using (var own = new Session())
    using ((session ?? own).AdvertiseRaw("raw", Schema.Raw("my.bytes")))
      (session ?? own).WaitForSubscribers("raw", 1, timeout);
  }

  [Test]
  public static void TextsThatCWouldCutAreRefused() {
    const string cut = "words\0more";
    using (var session = new Session())
    using (Params parameters = session.OpenParams())
    using (Transforms transforms = session.OpenTransforms()) {
      var uses = new Action[] {
        () => new Session("{}\0"),
        () => new Session("", new SessionOptions { Name = cut }),
        () => Session.FromFiles(new[] { cut }),
        () => session.Log(LogLevel.Info, cut),
        () => session.Advertise(cut, Log),
        () => session.Subscribe(cut, Log),
        () => session.Subscribe("words", Log, new SubscribeOptions { Name = cut }),
        () => session.Listen(cut, Log, log => { }),
        () => session.WaitForSubscribers(cut, 1, Patience),
        () => session.WaitForPublishers(cut, 1, Patience),
        () => session.Serve(cut, Log, Log, log => log),
        () => session.Call(cut, Log, Log, new DynamicMessage(Log), Patience),
        () => Soon(session.CallAsync(cut, Log, Log, new DynamicMessage(Log), Patience)),
        () => session.OpenParams(cut),
        () => Schema.Known(cut),
        () => Schema.Raw(cut),
        () => parameters.Declare(cut, 1),
        () => parameters.Declare("a", cut),
        () => parameters.Declare("a", "b", new ParamInfo { Unit = cut }),
        () => parameters.Declare("a", "b", new ParamInfo { Choices = new[] { "b", cut } }),
        () => parameters.Set(cut, 1),
        () => parameters.Set("a", cut),
        () => parameters.SetYaml("a", cut),
        () => parameters.GetText(cut),
        () => parameters.Remove(cut),
        () => parameters.OnChange(cut, (path, yaml) => { }),
        () => transforms.SetStatic("map", cut, new Transform()),
        () => transforms.Lookup("map", cut)
      };
      foreach (Action use in uses) Contains("U+0000", Fails(Code.InvalidArgument, use));
      using (session.Serve("fails", Log, Log, log => { throw new Exception("a\0b"); }))
        Equal("a b",
          Fails(Code.HandlerFailed, () => session.Call("fails", Log, Log, new DynamicMessage(Log), Patience)));
    }
  }

  [Test]
  public static void TextsWithHalfASurrogatePairAreRefused() {
    string half = "words \ud83d";
    using (var session = new Session()) {
      Contains("surrogate", Fails(Code.InvalidArgument, () => session.Log(LogLevel.Info, half)));
      Contains("surrogate", Fails(Code.InvalidArgument, () => session.AdvertiseRaw(half, Schema.Known("foxglove.Log"))));
      Contains("surrogate", Fails(Code.InvalidArgument, () => session.OpenParams(half)));
      using (session.Serve("fails", Log, Log, log => { throw new Exception(half); }))
        Equal("words \ufffd",
          Fails(Code.HandlerFailed, () => session.Call("fails", Log, Log, new DynamicMessage(Log), Patience)));
    }  // It ends.
  }

  [Test]
  public static void TheLogGoesToTheProgram() {
    var lines = new BlockingCollection<string>();
    string file = Path.GetTempFileName();
    File.WriteAllText(file, "shared_memory: {limit_bytes: 1000000}\n");
    var options = new SessionOptions { Name = "lögger", Log = (level, line) => lines.Add(level + " " + line) };
    using (var session = Session.FromFiles(new[] { file }, options)) {
      File.Delete(file);
      Equal("lögger", session.Name);
      session.SetLogLevel(LogLevel.Warning);
      session.Log(LogLevel.Info, "It is dry.");
      session.Log(LogLevel.Warning, "It rains.");
      string line;
      do True(lines.TryTake(out line, Patience), "the line comes");
      while (line.StartsWith("Info") && !line.Contains("dry"));
      Equal("Warning It rains.", line);
    }
  }

  [Test]
  public static void PeersAndChannelsAreSeen() {
    var came = new BlockingCollection<ulong>();
    var left = new BlockingCollection<string>();
    using (var here = new Session())
    using (here.OnPeer((happened, peer, channel, reason) => {
      if (happened == PeerEvent.Came) came.Add(peer.Id);
      if (happened == PeerEvent.Gone) left.Add(peer.Process + " " + reason);
    }))
    using (here.Subscribe("words", Log)) {
      var there = new Session("", new SessionOptions { Name = "other" });
      there.Advertise("words", Log);
      there.WaitForSubscribers("words", 1, Patience);
      ulong id;
      True(came.TryTake(out id, Patience), "a session comes");
      Equal(there.Id, id);
      Equal("other", here.Peers().Single().Process);
      // A pair that has no shared memory within two seconds begins with ZeroMQ, and moves later.
      Until("shared memory is used", () => here.Peers().Single().Transport == "shared memory");
      Until("the channel is known", () => here.Channels().Any(channel => channel.Name == "words" &&
        channel.TypeName == "foxglove.Log" && channel.Publishers == 1 && channel.Subscribers == 1));
      there.Dispose();
      string why;
      True(left.TryTake(out why, Patience), "it goes");
      Contains("other ", why);
    }
  }
}
