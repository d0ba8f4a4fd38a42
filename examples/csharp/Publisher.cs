using System;
using Hgros;

// Publishes five greetings, which nobody has to wait for: the channel keeps the newest ones for late subscribers.
internal static class Publisher {
  private static void Main() {
    var log = DynamicType.Known("foxglove.Log");
    using (var session = new Session())
    using (var publisher = session.Advertise("greetings", log, latched: 5)) {
      for (int i = 1; i <= 5; ++i) publisher.PublishWait(new DynamicMessage(log) { ["message"] = "Hello " + i });
      session.WaitForSubscribers("greetings", 1, TimeSpan.FromMinutes(1));
      Console.WriteLine("published");
    }
  }
}
