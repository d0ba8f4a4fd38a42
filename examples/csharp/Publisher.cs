using System;
using Hgros;

// Publishes five greetings as soon as somebody subscribes.
internal static class Publisher {
  private static void Main() {
    var log = DynamicType.Known("foxglove.Log");
    using (var session = new Session())
    using (var publisher = session.Advertise("greetings", log, latched: 5)) {
      session.WaitForSubscribers("greetings", 1, TimeSpan.FromMinutes(1));
      for (int i = 1; i <= 5; ++i) publisher.PublishWait(new DynamicMessage(log) { ["message"] = "Hello " + i });
      Console.WriteLine("published");
    }
  }
}
