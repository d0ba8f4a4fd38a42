using System;
using Hgros;

// Shows messages of any type with the description that comes with the channel: Subscriber.exe CHANNEL [COUNT].
internal static class Subscriber {
  private static int Main(string[] arguments) {
    if (arguments.Length < 1) {
      Console.Error.WriteLine("usage: Subscriber.exe CHANNEL [COUNT]");
      return 2;
    }
    int count = arguments.Length > 1 ? int.Parse(arguments[1]) : -1;
    using (var session = new Session())
    using (var queue = session.SubscribeRaw(arguments[0], new SubscribeOptions { KeepAll = 100 })) {
      Console.CancelKeyPress += (sender, pressed) => {
        pressed.Cancel = true;
        session.End();
      };
      try {
        for (; count != 0; --count)
          using (Message message = queue.Take())
            Console.WriteLine(message.Schema.TypeName + ": " + message.Decode());
      } catch (HgrosException failure) when (failure.Code == Code.Closed) {}
    }
    return 0;
  }
}
