using System;
using System.Diagnostics;
using System.Reflection;
using System.Runtime.InteropServices;
using System.Threading;

namespace Hgros {
  // Calls from the library into the program. `user` is a GCHandle of the program's object, until Release is called.
  // No exception leaves such a call: it would have to unwind through C.
  internal static class Callbacks {
    [ThreadStatic] private static int depth;
    [ThreadStatic] private static bool known; // Whether this thread was here before.
    private static long unreported;

    internal static readonly Native.Release Release = user => {
      if (!known) LeaveOutOfShutdown(); // It may be all that this thread ever runs.
      if (user != IntPtr.Zero) GCHandle.FromIntPtr(user).Free();
    };

    // Whether this thread runs a callback.
    internal static bool Running => depth > 0;

    internal static IntPtr User(object target) => GCHandle.ToIntPtr(GCHandle.Alloc(target));

    // Calls the library with a target, which the library releases, also if it refuses. A call that does not reach the
    // library, such as one with a disposed handle, releases it here.
    internal static void Give(object target, Func<IntPtr, int> call) {
      IntPtr user = User(target);
      int status;
      try {
        status = call(user);
      } catch {
        GCHandle.FromIntPtr(user).Free();
        throw;
      }
      HgrosException.Check(status);
    }

    internal static T Target<T>(IntPtr user) => (T)GCHandle.FromIntPtr(user).Target;

    // Runs a callback of the program. Its exception, if there is one, goes to `failed`.
    internal static void Run(Action callback, Action<Exception> failed) {
      if (!known) LeaveOutOfShutdown();
      ++depth;
      try {
        callback();
      } catch (Exception exception) {
        Report(exception, failed);
      } finally {
        --depth;
      }
    }

    // Before 6.12, Mono waits at its end for each foreign thread that has ever run managed code (mono/mono#20466), but
    // the library keeps its workers. So they get the flag by which Mono leaves threads of its own alone.
    private static void LeaveOutOfShutdown() {
      known = true;
      const BindingFlags fields = BindingFlags.NonPublic | BindingFlags.Instance;
      object thread = typeof(Thread).GetField("internal_thread", fields)?.GetValue(Thread.CurrentThread);
      FieldInfo flags = thread?.GetType().GetField("flags", fields);
      if (flags == null || flags.FieldType != typeof(IntPtr) || !IsForeign()) return;
      const int dontManage = 1;
      flags.SetValue(thread, (IntPtr)((long)(IntPtr)flags.GetValue(thread) | dontManage));
    }

    // A foreign thread begins with a callback, every other with code of the program or of Mono.
    private static bool IsForeign() {
      var stack = new StackTrace();
      MethodBase first = stack.GetFrame(stack.FrameCount - 1)?.GetMethod();
      return first?.DeclaringType?.Assembly == typeof(Callbacks).Assembly;
    }

    private static void Report(Exception exception, Action<Exception> failed) {
      try {
        failed(exception);
      } catch (Exception second) {
        const int most = 10;
        long line = Interlocked.Increment(ref unreported);
        if (line > most) return;
        Console.Error.WriteLine("hgros: an exception of a callback cannot be reported: " + second.Message + "\n" +
          exception + (line == most ? "\nhgros: further exceptions like this one are not written." : ""));
      }
    }
  }
}
