using System;
using System.Collections.Generic;
using System.Linq;
using System.Runtime.InteropServices;
using System.Threading;

namespace Hgros {
  // Closes the sessions that are open when the program ends, so that no thread of the library enters Mono while it
  // takes itself apart, which would end in a crash.
  internal static class AtExit {
    [DllImport("libc")] private static extern void _exit(int code);

    private static readonly TimeSpan Patience = TimeSpan.FromSeconds(2); // For callbacks that do not return.

    private static readonly List<WeakReference> sessions = new List<WeakReference>(); // Locked.

    static AtExit() {
      AppDomain.CurrentDomain.ProcessExit += (sender, arguments) => CloseSessions();
    }

    // A session that is forgotten is closed by its finalizer.
    internal static void Add(SessionHandle session) {
      lock (sessions) {
        sessions.RemoveAll(reference => !reference.IsAlive);
        sessions.Add(new WeakReference(session, true)); // Also while its finalizer has not run.
      }
    }

    private static void CloseSessions() {
      SessionHandle[] open;
      lock (sessions)
        open = sessions.Select(reference => (SessionHandle)reference.Target)
          .Where(session => session != null && !session.IsInvalid && !session.IsClosed).ToArray();
      if (open.Length == 0) return;
      var closing = new Thread(() => Close(open)) { IsBackground = true, Name = "hgros end" };
      closing.Start();
      // Mono waits for ever if a callback still runs, such as one that ends the program.
      if (Callbacks.Running || !closing.Join(Patience)) _exit(Environment.ExitCode);
    }

    private static void Close(SessionHandle[] open) {
      foreach (SessionHandle session in open) {
        try {
          Native.hgros_session_end(session); // Wakes all that wait, and so hold the handle.
        } catch (ObjectDisposedException) {
          continue; // Another thread was faster.
        }
        session.Dispose();
      }
      foreach (SessionHandle session in open) session.Freed.Wait(Patience);
    }
  }
}
