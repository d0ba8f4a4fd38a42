using System;
using System.Runtime.InteropServices;
using System.Threading;
using Microsoft.Win32.SafeHandles;

namespace Hgros {
  // Handles of the library. A call of the library holds the handle that it gets, so any thread may dispose one while
  // others use it: the last one out closes it. The library takes them in any order, so finalizers may, too.
  internal abstract class Handle : SafeHandleZeroOrMinusOneIsInvalid {
    protected Handle() : base(true) {}

    // After AtExit, finalizers run, but no callback enters Mono or leaves it any more: what waits for one would wait
    // for ever. Then the system frees everything.
    protected sealed override bool ReleaseHandle() {
      if (Environment.HasShutdownStarted) Leave();
      else Close(handle);
      return true;
    }

    protected abstract void Close(IntPtr opened);

    protected virtual void Leave() {}

    // What must wait for callbacks is closed on another thread if this one runs a callback.
    protected static void Outside(Action close) {
      if (Callbacks.Running) ThreadPool.QueueUserWorkItem(_ => close());
      else close();
    }
  }

  internal sealed class SessionHandle : Handle {
    internal readonly ManualResetEventSlim Freed = new ManualResetEventSlim();

    public SessionHandle() {
      AtExit.Add(this);
    }

    protected override void Close(IntPtr opened) => Outside(() => {
      Native.hgros_session_close(opened);
      Freed.Set();
    });

    protected override void Leave() => Freed.Set();
  }

  internal sealed class SchemaHandle : Handle {
    protected override void Close(IntPtr opened) => Native.hgros_schema_free(opened);
  }

  internal sealed class PublisherHandle : Handle {
    protected override void Close(IntPtr opened) => Native.hgros_publisher_close(opened);
  }

  internal sealed class SubscriptionHandle : Handle {
    protected override void Close(IntPtr opened) => Native.hgros_subscription_close(opened);
  }

  internal sealed class ServiceHandle : Handle {
    protected override void Close(IntPtr opened) => Native.hgros_service_close(opened);
  }

  internal sealed class PendingCallHandle : Handle {
    protected override void Close(IntPtr opened) => Native.hgros_call_free(opened);
  }

  internal sealed class WatchHandle : Handle {
    protected override void Close(IntPtr opened) => Native.hgros_watch_close(opened);
  }

  internal sealed class ParamsHandle : Handle {
    protected override void Close(IntPtr opened) => Outside(() => Native.hgros_params_close(opened));
  }

  internal sealed class TransformsHandle : Handle {
    protected override void Close(IntPtr opened) => Outside(() => Native.hgros_transforms_close(opened));
  }
}
