using System;
using System.Diagnostics;
using System.Threading;
using Hgros;
using static Test;

// Programs in C++: the command `hgros`.
public static class CommandTest {
  private static readonly DynamicType Log = DynamicType.Known("foxglove.Log");

  [Test]
  public static void TheCommandShowsMessages() {
    using (var session = new Session())
    using (var publisher = session.Advertise("words", Log, latched: 1)) {
      publisher.Publish(new DynamicMessage(Log) { ["message"] = "from C#" });
      Contains("from C#", Tool.Text(Tool.Run("HGROS", "echo words --once --timeout 40")));
    }
  }

  [Test]
  public static void MessagesOfTheCommandCome() {
    using (var session = new Session())
    using (var queue = session.Subscribe("words", Log)) {
      Tool.Run("HGROS", "pub words '{message: from C++}' --type foxglove.Log --timeout 40");
      Equal("from C++", (string)queue.Next(new CancellationTokenSource(Patience).Token)["message"]);
    }
  }

  [Test]
  public static void TheCommandCallsServices() {
    using (var session = new Session())
    using (session.Serve("ask", Log, Log, word => {
      if ((string)word["message"] == "fail") throw new Exception("asked to fail");
      return new DynamicMessage(Log) { ["message"] = "re: " + word["message"] };
    })) {
      Contains("re: hello", Tool.Text(Tool.Run("HGROS", "call ask '{message: hello}' --timeout 40")));
      using (Process failing = Tool.Start("HGROS", "call ask '{message: fail}' --timeout 40")) {
        failing.StandardOutput.ReadToEnd();
        failing.WaitForExit();
        True(failing.ExitCode != 0, "a failed call ends with a failure");
      }
    }
  }
}
