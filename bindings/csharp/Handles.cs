using System;
using System.Runtime.InteropServices;
using System.Threading;
using Microsoft.Win32.SafeHandles;

namespace Hgros {
  // Handles of the library. A call of the library holds the handle that it gets, so any thread may dispose one while
  // others use it: the last one out closes it. The library takes them in any order, so finalizers may, too.
  internal abstract class Handle : SafeHandleZeroOrMinusOneIsInvalid {
    protected Handle() : base(true) {}

    // What must wait for callbacks is closed on another thread if this one runs a callback.
    protected static void Outside(Action close) {
      if (Callbacks.Running) ThreadPool.QueueUserWorkItem(_ => close());
      else close();
    }
  }

  internal sealed class SessionHandle : Handle {
    internal readonly ManualResetEventSlim Freed = new ManualResetEventSlim();

    protected override bool ReleaseHandle() {
      IntPtr session = handle;
      Outside(() => {
        Native.hgros_session_close(session);
        Freed.Set();
      });
      return true;
    }
  }

  internal sealed class SchemaHandle : Handle {
    protected override bool ReleaseHandle() {
      Native.hgros_schema_free(handle);
      return true;
    }
  }

  internal sealed class PublisherHandle : Handle {
    protected override bool ReleaseHandle() {
      Native.hgros_publisher_close(handle);
      return true;
    }
  }

  internal sealed class SubscriptionHandle : Handle {
    protected override bool ReleaseHandle() {
      Native.hgros_subscription_close(handle);
      return true;
    }
  }

  internal sealed class ServiceHandle : Handle {
    protected override bool ReleaseHandle() {
      Native.hgros_service_close(handle);
      return true;
    }
  }

  internal sealed class PendingCallHandle : Handle {
    protected override bool ReleaseHandle() {
      Native.hgros_call_free(handle);
      return true;
    }
  }

  internal sealed class WatchHandle : Handle {
    protected override bool ReleaseHandle() {
      Native.hgros_watch_close(handle);
      return true;
    }
  }

  internal sealed class ParamsHandle : Handle {
    protected override bool ReleaseHandle() {
      IntPtr parameters = handle;
      Outside(() => Native.hgros_params_close(parameters));
      return true;
    }
  }

  internal sealed class TransformsHandle : Handle {
    protected override bool ReleaseHandle() {
      IntPtr transforms = handle;
      Outside(() => Native.hgros_transforms_close(transforms));
      return true;
    }
  }
}
