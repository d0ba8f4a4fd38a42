using System;
using System.Threading;
using System.Threading.Tasks;
using Hgros;
using static Test;

public static class ServicesTest {
  private static readonly DynamicType Log = DynamicType.Known("foxglove.Log");

  private static DynamicMessage Say(string text) => new DynamicMessage(Log) { ["message"] = text };

  // How a call fails; null: not at all.
  private static Code? CallFails(Session client, string name, TimeSpan timeout) {
    try {
      client.Call(name, Log, Log, Say(""), timeout);
      return null;
    } catch (HgrosException failure) {
      return failure.Code;
    }
  }

  private static DynamicMessage Shout(DynamicMessage word) {
    var text = (string)word["message"];
    if (text == "fail") throw new InvalidOperationException("I have no voice");
    return text == "nothing" ? null : Say(text.ToUpperInvariant());
  }

  [Test]
  public static void ServicesReplyAndFail() {
    using (var server = new Session())
    using (var client = new Session())
    using (server.Serve("shout", Log, Log, Shout)) {
      Task<DynamicMessage> missing = Task.Run(() => client.Call("nobody", Log, Log, Say(""), Patience));
      Func<string, string> call = text => (string)client.Call("shout", Log, Log, Say(text), Patience)["message"];
      Until("the service is known", () => CallFails(client, "shout", Patience) == null);
      Equal("HELLO", call("hello"));
      Equal("I have no voice", Fails(Code.HandlerFailed, () => call("fail")));
      Contains("foxglove.Log", Fails(Code.HandlerFailed, () => call("nothing")));
      Equal("SOON", (string)Soon(client.CallAsync("shout", Log, Log, Say("soon")))["message"]);
      Equal("I have no voice",
        Fails(Code.HandlerFailed, () => Soon(client.CallAsync("shout", Log, Log, Say("fail")))));
      Fails(Code.NoServer, () => Soon(missing));
      Fails(Code.Failed, () => server.Serve("shout", Log, Log, Shout));
      Equal(0L, server.FailedCallbacks);
      Equal(0UL, Message.Leases);
    }
  }

  [Test]
  public static void CallsTimeOutAndAreCancelled() {
    using (var server = new Session())
    using (var session = new Session()) {
      var entered = new SemaphoreSlim(0);
      var goOn = new ManualResetEventSlim();
      using (server.Serve("wait", Log, Log, word => {
        entered.Release();
        goOn.Wait(Patience);
        return word;
      }, new ServeOptions { Executor = Executor.Dedicated })) {
        Until("the service is known", () => CallFails(session, "wait", TimeSpan.Zero) == Code.TimedOut);
        Fails(Code.TimedOut, () => session.Call("wait", Log, Log, Say(""), TimeSpan.FromMilliseconds(20)));
        Fails(Code.TimedOut,
          () => Soon(session.CallAsync("wait", Log, Log, Say(""), TimeSpan.FromMilliseconds(20))));
        True(entered.Wait(Patience), "a handler runs");
        var cancel = new CancellationTokenSource();
        Task<DynamicMessage> call = session.CallAsync("wait", Log, Log, Say(""), null, cancel.Token);
        cancel.Cancel();
        Throws<OperationCanceledException>(() => Soon(call));
        call = session.CallAsync("wait", Log, Log, Say(""));
        session.End();
        Fails(Code.Closed, () => Soon(call));
        goOn.Set();
      }
    }
  }

  [Test]
  public static void HandlersCallTheirOwnSession() {
    using (var session = new Session("data_graph: {threads: 1}"))
    using (session.Serve("inner", Log, Log, Shout))
    using (session.Serve("outer", Log, Log, word => session.Call("inner", Log, Log, word, Patience))) {
      Equal("HELLO", (string)session.Call("outer", Log, Log, Say("hello"), Patience)["message"]);
      Equal("I have no voice", Fails(Code.HandlerFailed, () => session.Call("outer", Log, Log, Say("fail"), Patience)));
    }
  }
}
