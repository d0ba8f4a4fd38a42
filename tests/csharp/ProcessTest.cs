using System;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Runtime.InteropServices;
using System.Threading;
using Hgros;
using static Test;

// What is about a whole process: the end of a program, which must not wait for threads of the library, its memory, and what
// it writes.
public static class ProcessTest {
  private static readonly DynamicType Log = DynamicType.Known("foxglove.Log");

  // Callbacks run, or are about to, and nothing is disposed.
  private static void LeaveCallbacks() {
    var session = new Session();
    var publisher = session.Advertise("words", Log);
    for (int i = 0; i < 4; ++i) session.Listen("words", Log, log => { });
    for (int i = 0; i < 5; ++i) publisher.Publish(new DynamicMessage(Log));
  }

  [Test]
  public static void ExitDoesNotWaitForCallbacks() {
    LeaveCallbacks();
    Environment.Exit(0);
  }

  [Test]
  public static void MainReturnsWhileCallbacksRun() {
    LeaveCallbacks();
  }

  [Test]
  public static void ExitEndsAlsoInsideACallback() {
    var session = new Session();
    session.Listen("words", Log, log => Environment.Exit(0));
    session.Advertise("words", Log).Publish(new DynamicMessage(Log));
    new ManualResetEvent(false).WaitOne(Patience);
    throw new Exception("The program did not end.");
  }

  [Test]
  public static void ExitDoesNotWaitForACallbackThatDoesNotReturn() {
    var session = new Session();
    var entered = new ManualResetEventSlim();
    session.Listen("words", Log, log => {
      entered.Set();
      new ManualResetEvent(false).WaitOne();
    });
    session.Advertise("words", Log).Publish(new DynamicMessage(Log));
    True(entered.Wait(Patience), "the callback runs");
    Environment.Exit(0);
  }

  [Test]
  public static void MemoryStaysTheSameOver100kMessages() {
    using (var session = new Session())
    using (var queue = session.Subscribe("words", Log, new SubscribeOptions { KeepAll = 100 }))
    using (var publisher = session.Advertise("words", Log))
    using (var callbacks = session.Advertise("more", Log)) {
      int heard = 0;
      using (session.Listen("more", Log, log => Interlocked.Increment(ref heard),
        new SubscribeOptions { KeepAll = 100 })) {
        Action<int> send = count => {
          for (int i = 0; i < count; ++i) {
            publisher.Publish(new DynamicMessage(Log) { ["message"] = new string('x', 1000) });
            Equal(1000, ((string)queue.Next()["message"]).Length);
            callbacks.PublishWait(new DynamicMessage(Log), Patience);
          }
        };
        send(10000);
        long before = Resident();
        send(50000);
        long grown = Resident() - before;
        True(grown < 10 << 20, "100000 messages leave less than 10 MB, not " + grown);
        Until("all callbacks run", () => heard == 60000);
      }
      Equal(0UL, Message.Leases);
    }
  }

  [Test]
  public static void ExceptionsThatNoSessionCanLogAreWrittenTenTimes() {
    var written = new StringWriter();
    TextWriter writer = TextWriter.Synchronized(written);
    Console.SetError(writer);
    int ended = 0;
    using (var publisher = new Session()) {
      RawPublisher go = publisher.AdvertiseRaw("go", Schema.Raw("Go"));
      for (int i = 0; i < 15; ++i) {
        var session = new Session();
        session.ListenRaw("go", message => {
          session.Dispose();
          Interlocked.Increment(ref ended);
          throw new InvalidOperationException("no way");
        });
      }
      publisher.WaitForSubscribers("go", 15, Patience);
      go.Publish(new byte[1]);
      Until("all callbacks have run", () => Volatile.Read(ref ended) == 15);
      Until("ten are written", () => {  // Perhaps the last line first.
        string[] lines;
        lock (writer) lines = written.ToString().Split('\n');  // As its methods do.
        return lines.Count(line => line.StartsWith("hgros: an exception of a callback cannot be reported: ")) == 10 &&
               lines.Count(line => line.Contains("InvalidOperationException: no way")) == 10 &&
               lines.Any(line => line.Contains("further exceptions"));
      });
    }
  }

  private static long Resident() {
    GC.Collect();
    GC.WaitForPendingFinalizers();
    string pages = File.ReadAllText("/proc/self/statm").Split(' ')[1];
    return long.Parse(pages) * Environment.SystemPageSize;
  }

  // The rest uses the C interface itself.
  private const string Library = "libhgros_c.so.0";

  [DllImport(Library)]
  private static extern int hgros_session_open(string yaml, IntPtr options, out IntPtr session);
  [DllImport(Library)]
  private static extern int hgros_schema_known(string name, out IntPtr schema);
  [DllImport(Library)]
  private static extern int hgros_publisher_open(IntPtr session, string channel, IntPtr schema, IntPtr options,
    out IntPtr publisher);
  [DllImport(Library)]
  private static extern int hgros_subscribe(IntPtr session, string channel, IntPtr options, IntPtr callback,
    IntPtr user, IntPtr release, out IntPtr subscription);
  [DllImport(Library)]
  private static extern int hgros_publish_borrowed(IntPtr publisher, byte[] data, UIntPtr size, IntPtr user,
    IntPtr release, long timeout);
  [DllImport("libdl.so.2")]
  private static extern IntPtr dlopen(string file, int flags);
  [DllImport("libdl.so.2")]
  private static extern IntPtr dlsym(IntPtr library, string name);

  private sealed class Watched {
    internal readonly ManualResetEventSlim Gone;

    internal Watched(ManualResetEventSlim gone) {
      Gone = gone;
    }

    ~Watched() => Gone.Set();
  }

  // A worker of the library drops the last use of a message, and runs no other code of the program than its release.
  [Test]
  public static void ThreadsThatOnlyReleaseDoNotHoldUpTheEnd() {
    const BindingFlags flags = BindingFlags.NonPublic | BindingFlags.Static;
    Type callbacks = typeof(Session).Assembly.GetType("Hgros.Callbacks", true);
    var release = (Delegate)callbacks.GetField("Release", flags).GetValue(null);
    IntPtr function = Marshal.GetFunctionPointerForDelegate(release);
    IntPtr session, schema, publisher, subscription;
    Equal(0, hgros_session_open("", IntPtr.Zero, out session));
    Equal(0, hgros_schema_known("foxglove.Log", out schema));
    Equal(0, hgros_publisher_open(session, "words", schema, IntPtr.Zero, out publisher));
    // A function of C that looks at its first argument alone, which is NULL.
    IntPtr callback = dlsym(dlopen(Library, 1), "hgros_session_id");
    True(callback != IntPtr.Zero, "the library has the function");
    Equal(0, hgros_subscribe(session, "words", IntPtr.Zero, callback, IntPtr.Zero, IntPtr.Zero, out subscription));
    var gone = new ManualResetEventSlim();
    for (int i = 0; i < 20; ++i) {
      IntPtr user = GCHandle.ToIntPtr(GCHandle.Alloc(new Watched(gone)));
      Equal(0, hgros_publish_borrowed(publisher, new byte[0], UIntPtr.Zero, user, function, 0));
    }
    Until("the messages are released", () => {
      GC.Collect();
      return gone.Wait(1);
    });
  }
}
