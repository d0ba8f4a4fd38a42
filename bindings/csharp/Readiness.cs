using System;
using System.Collections.Generic;
using System.ComponentModel;
using System.Runtime.InteropServices;
using System.Threading;
using System.Threading.Tasks;

namespace Hgros {
  // Tasks that wait until a queue has a message or has ended. One thread of the process waits for all descriptors.
  internal static class Readiness {
    [StructLayout(LayoutKind.Sequential)]
    private struct PollEntry {
      internal int Descriptor;
      internal short Events, Happened;
    }

    [DllImport("libc", SetLastError = true)]
    private static extern int poll([In, Out] PollEntry[] entries, UIntPtr count, int timeoutMs);
    [DllImport("libc", SetLastError = true)] private static extern int eventfd(uint start, int flags);
    [DllImport("libc", SetLastError = true)] private static extern IntPtr read(int file, ref ulong value, IntPtr size);
    [DllImport("libc", SetLastError = true)] private static extern IntPtr write(int file, ref ulong value, IntPtr size);

    private const short Readable = 1;         // POLLIN
    private const int CloseOnExec = 0x80000;  // EFD_CLOEXEC
    private const int Interrupted = 4;        // EINTR

    private sealed class Waiter {
      internal SubscriptionHandle Queue;
      internal int Descriptor;
      // Goes on elsewhere: the thread must not run the program's code.
      internal readonly TaskCompletionSource<bool> Done =
        new TaskCompletionSource<bool>(TaskCreationOptions.RunContinuationsAsynchronously);
    }

    private static readonly List<Waiter> waiters = new List<Waiter>(); // Locked, and so is what follows.
    // Queues that nobody waits for any more: the thread lets them go when it does not use their descriptors.
    private static readonly List<SubscriptionHandle> released = new List<SubscriptionHandle>();
    private static int wake = -1;

    // Ends when the queue is readable or the token is cancelled.
    internal static async Task Wait(SubscriptionHandle queue, CancellationToken token) {
      bool held = false;
      var waiter = new Waiter { Queue = queue };
      try {
        queue.DangerousAddRef(ref held); // Keeps the descriptor open.
        waiter.Descriptor = Native.hgros_queue_descriptor(queue);
        lock (waiters) {
          if (wake < 0) Start();
          waiters.Add(waiter);
          Wake();
        }
        using (token.Register(() => waiter.Done.TrySetCanceled(token)))
          await waiter.Done.Task.ConfigureAwait(false);
      } finally {
        if (held) Leave(waiter);
      }
    }

    private static void Leave(Waiter waiter) {
      lock (waiters) {
        if (waiters.Remove(waiter)) {
          released.Add(waiter.Queue);
          Wake();
          return;
        }
      }
      waiter.Queue.DangerousRelease(); // The thread has left it.
    }

    private static void Start() {
      wake = eventfd(0, CloseOnExec);
      if (wake < 0) throw new Win32Exception(Marshal.GetLastWin32Error());
      new Thread(Loop) { IsBackground = true, Name = "hgros queues" }.Start();
    }

    private static void Wake() {
      ulong one = 1;
      write(wake, ref one, (IntPtr)sizeof(ulong));
    }

    private static void Loop() {
      var watched = new List<Waiter>();
      while (true) {
        var gone = new List<SubscriptionHandle>();
        lock (waiters) {
          watched.Clear();
          watched.AddRange(waiters);
          gone.AddRange(released);
          released.Clear();
        }
        foreach (SubscriptionHandle queue in gone) queue.DangerousRelease();
        var entries = new PollEntry[watched.Count + 1];
        entries[0] = new PollEntry { Descriptor = wake, Events = Readable };
        for (int i = 0; i < watched.Count; ++i)
          entries[i + 1] = new PollEntry { Descriptor = watched[i].Descriptor, Events = Readable };
        if (poll(entries, (UIntPtr)(uint)entries.Length, -1) < 0) {
          int error = Marshal.GetLastWin32Error();
          if (error == Interrupted) continue;
          throw new Win32Exception(error);
        }
        ulong count = 0;
        if (entries[0].Happened != 0) read(wake, ref count, (IntPtr)sizeof(ulong));
        for (int i = 0; i < watched.Count; ++i) {
          if (entries[i + 1].Happened == 0) continue;
          lock (waiters) waiters.Remove(watched[i]);
          watched[i].Done.TrySetResult(true);
        }
      }
    }
  }
}
