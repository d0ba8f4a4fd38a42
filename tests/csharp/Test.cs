using System;
using System.Diagnostics;
using System.Linq;
using System.Reflection;
using System.Threading;
using System.Threading.Tasks;
using Hgros;

// A public static method with this attribute is a test. The program runs one or those of a class: `Tests.exe NAME`.
[AttributeUsage(AttributeTargets.Method)]
internal sealed class TestAttribute : Attribute {}

internal static class Test {
  internal static readonly TimeSpan Patience = TimeSpan.FromSeconds(45);

  private static int Main(string[] arguments) {
    int failed = 0, run = 0;
    foreach (MethodInfo test in typeof(Test).Assembly.GetTypes().SelectMany(type => type.GetMethods())
      .Where(method => method.IsDefined(typeof(TestAttribute), false) &&
        (method.Name == arguments[0] || method.DeclaringType.Name == arguments[0]))) {
      string domain = "csharp-" + Process.GetCurrentProcess().Id + "-" + ++run;
      Environment.SetEnvironmentVariable("HGROS_DOMAIN", domain);
      Console.WriteLine("RUN " + test.Name);
      try {
        ((Action)Delegate.CreateDelegate(typeof(Action), test))();
        Console.WriteLine("PASS " + test.Name);
      } catch (Exception failure) {
        Console.WriteLine("FAIL " + test.Name + ": " + failure);
        ++failed;
      }
    }
    Console.WriteLine(run + " run, " + failed + " failed");
    return failed == 0 && run > 0 ? 0 : 1;
  }

  internal static void Equal<T>(T wanted, T got) {
    if (!Equals(wanted, got)) throw new Exception("\"" + got + "\" instead of \"" + wanted + "\"");
  }

  internal static void True(bool holds, string what) {
    if (!holds) throw new Exception("It does not hold that " + what + ".");
  }

  internal static void Contains(string part, string text) => True(text.Contains(part), "\"" + text + "\" has " + part);

  // The exception of an action, which must be of that type.
  internal static T Throws<T>(Action action) where T : Exception {
    try {
      action();
    } catch (T expected) {
      return expected;
    }
    throw new Exception("There was no " + typeof(T).Name + ".");
  }

  // The sentence of a failure, which must be of that code.
  internal static string Fails(Code code, Action action) {
    var failure = Throws<HgrosException>(action);
    Equal(code, failure.Code);
    return failure.Sentence;
  }

  internal static void Until(string what, Func<bool> holds) {
    var watch = Stopwatch.StartNew();
    while (!holds()) {
      True(watch.Elapsed < Patience, what + " in time");
      Thread.Yield();
    }
  }

  internal static T Soon<T>(Task<T> task) {
    True(Task.WaitAny(new Task[] { task }, Patience) == 0, "a task ends in time");
    return task.GetAwaiter().GetResult();
  }

  internal static void Soon(Thread thread) => True(thread.Join(Patience), "a thread ends in time");

  internal static Thread Run(Action action) {
    var thread = new Thread(() => action()) { IsBackground = true };
    thread.Start();
    return thread;
  }
}
