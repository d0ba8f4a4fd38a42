using System;
using System.Collections.Generic;
using System.Linq;
using System.Runtime.InteropServices;
using System.Threading;

namespace Hgros {
  /// <summary>The weight of a line of the log.</summary>
  public enum LogLevel {
    /// <summary>For those who look for a fault.</summary>
    Debug,
    /// <summary>What happens.</summary>
    Info,
    /// <summary>What may be a fault.</summary>
    Warning,
    /// <summary>What is a fault.</summary>
    Error
  }

  /// <summary>Read when a session is opened.</summary>
  public sealed class SessionOptions {
    /// <summary>For logs and other sessions' tables; null: the program's name.</summary>
    public string Name { get; set; }
    /// <summary>Gets the log, a line at a time, instead of standard error. It must not call the binding.</summary>
    public Action<LogLevel, string> Log { get; set; }
  }

  /// <summary>One participant of the hypergraph. All of it may be used by any thread and inside callbacks. Dispose
  /// ends the session and all that was made from it.</summary>
  public sealed partial class Session : IDisposable {
    private static readonly Native.LogCallback WriteLog = (user, level, text) =>
      Callbacks.Run(() => Callbacks.Target<Action<LogLevel, string>>(user)((LogLevel)level,
        Marshal.PtrToStringAnsi(text)),
        exception => Console.Error.WriteLine("hgros: the function for the log failed: " + exception));

    private readonly SessionHandle handle;
    private HashSet<IDisposable> children = new HashSet<IDisposable>(); // What calls back. null once it is disposed.
    private readonly object childrenLock = new object();
    private long failedCallbacks;

    /// <summary>Opens a session with a configuration as YAML. Without one it finds the sessions of this user on
    /// this host.</summary>
    public Session(string yaml = null, SessionOptions options = null) {
      string text = Texts.Uncut(yaml);
      Native.SessionOptions chosen = Chosen(options);
      HgrosException.Check(Native.hgros_session_open(text, ref chosen, out handle));
    }

    private Session(string[] files, SessionOptions options) {
      string[] paths = Texts.Uncut(files);
      Native.SessionOptions chosen = Chosen(options);
      HgrosException.Check(
        Native.hgros_session_open_files(paths, (UIntPtr)(uint)files.Length, ref chosen, out handle));
    }

    /// <summary>Opens a session with configuration files, which are merged.</summary>
    public static Session FromFiles(IEnumerable<string> files, SessionOptions options = null) =>
      new Session(files.ToArray(), options);

    private static Native.SessionOptions Chosen(SessionOptions options) {
      var chosen = new Native.SessionOptions {
        Size = Native.SizeOf<Native.SessionOptions>(), Name = Texts.Uncut(options?.Name)
      };
      if (options?.Log != null) {
        chosen.Log = WriteLog;
        chosen.LogUser = Callbacks.User(options.Log);
        chosen.LogRelease = Callbacks.Release;
      }
      return chosen;
    }

    /// <summary>The session's name.</summary>
    public string Name {
      get {
        bool held = false;
        try {
          handle.DangerousAddRef(ref held); // The name lives as long as the session.
          return Marshal.PtrToStringAnsi(Native.hgros_session_name(handle));
        } finally {
          if (held) handle.DangerousRelease();
        }
      }
    }

    /// <summary>The session's id, as MessageInfo.Publisher of its messages has it.</summary>
    public ulong Id => Native.hgros_session_id(handle);

    /// <summary>The number of exceptions that callbacks of the session did not catch. The log has lines about
    /// them: ten, then fewer and fewer.</summary>
    public long FailedCallbacks => Interlocked.Read(ref failedCallbacks);

    /// <summary>Writes a line into the session's log.</summary>
    public void Log(LogLevel level, string line) =>
      HgrosException.Check(Native.hgros_session_log(handle, (int)level, Texts.Uncut(line)));

    /// <summary>Lines below a level are not written from now on.</summary>
    public void SetLogLevel(LogLevel level) =>
      HgrosException.Check(Native.hgros_session_set_log_level(handle, (int)level));

    /// <summary>Waits until a channel that this session publishes has at least this many subscribers.</summary>
    public void WaitForSubscribers(string channel, int count = 1, TimeSpan? timeout = null,
      CancellationToken token = default) =>
      Waiting.Run(timeout, token, left =>
        Native.hgros_session_wait_for_subscribers(handle, Texts.Uncut(channel), (UIntPtr)(uint)count, left));

    /// <summary>Waits until at least this many other sessions that publish on a channel are connected.</summary>
    public void WaitForPublishers(string channel, int count = 1, TimeSpan? timeout = null,
      CancellationToken token = default) =>
      Waiting.Run(timeout, token, left =>
        Native.hgros_session_wait_for_publishers(handle, Texts.Uncut(channel), (UIntPtr)(uint)count, left));

    /// <summary>Wakes all that wait for the session; every later call throws HgrosException with Code.Closed. It
    /// does not wait. Dispose the session later.</summary>
    public void End() => Native.hgros_session_end(handle);

    /// <summary>Ends the session, waits for running callbacks, and says goodbye to the other sessions. Inside a
    /// callback it does not wait: the session is closed when the callback has returned.</summary>
    public void Dispose() {
      if (!handle.IsClosed) EndUnlessClosed();
      handle.Dispose();
      HashSet<IDisposable> last;
      lock (childrenLock) {
        last = children;
        children = null;
      }
      foreach (IDisposable child in last ?? new HashSet<IDisposable>()) child.Dispose();
      if (!Callbacks.Running) handle.Freed.Wait();
    }

    // A child lives until it or the session is disposed.
    internal T Keep<T>(T child) where T : IDisposable {
      bool kept;
      lock (childrenLock) kept = children?.Add(child) ?? false;
      if (!kept) child.Dispose();
      return child;
    }

    internal void Forget(IDisposable child) {
      lock (childrenLock) children?.Remove(child);
    }

    private void EndUnlessClosed() {
      try {
        End();
      } catch (ObjectDisposedException) {
        // Another thread was faster.
      }
    }

    // Runs a callback of the program; what it throws is counted and goes to the log.
    internal void Run(string what, Action callback) => Callbacks.Run(callback, exception => {
      Interlocked.Increment(ref failedCallbacks);
      string line = Texts.Mended((what + " threw " + exception).Replace(Environment.NewLine, " "));
      Native.hgros_session_log_limited(handle, (int)LogLevel.Error, Texts.Mended(what), line);
    });
  }
}
