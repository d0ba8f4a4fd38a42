using System;
using System.Diagnostics;
using System.Threading;

namespace Hgros {
  // Timeouts of the library, which are nanoseconds, and waits that a token ends.
  internal static class Waiting {
    private const long SliceNs = 50 * 1000000L;
    private const int TimedOut = (int)Code.TimedOut;

    // null waits forever.
    internal static long Nanoseconds(TimeSpan? timeout) {
      if (timeout == null || timeout == Timeout.InfiniteTimeSpan) return -1;
      if (timeout < TimeSpan.Zero)
        throw new ArgumentOutOfRangeException(nameof(timeout), "The timeout must not be negative.");
      long ticks = timeout.Value.Ticks;
      return ticks > long.MaxValue / 100 ? -1 : ticks * 100;
    }

    // Runs a wait of the library. Nothing cuts one short, so with a token it waits in slices.
    internal static void Run(TimeSpan? timeout, CancellationToken token, Func<long, int> wait) {
      long whole = Nanoseconds(timeout);
      if (!token.CanBeCanceled) {
        HgrosException.Check(wait(whole));
        return;
      }
      var watch = Stopwatch.StartNew();
      while (true) {
        token.ThrowIfCancellationRequested();
        long left = whole < 0 ? SliceNs : Math.Max(0, whole - watch.Elapsed.Ticks * 100);
        int status = wait(Math.Min(left, SliceNs));
        if (status == 0) return;
        if (status != TimedOut || (whole >= 0 && left <= SliceNs)) throw HgrosException.Last(status);
      }
    }
  }
}
