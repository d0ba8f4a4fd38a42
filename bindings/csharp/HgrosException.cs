using System;
using System.Runtime.InteropServices;

namespace Hgros {
  /// <summary>The kind of a failure (hgros/c/status.h).</summary>
  public enum Code {
    /// <summary>A value is missing, or a number is outside its range.</summary>
    InvalidArgument = 1,
    /// <summary>Wiring failed for another reason: a name, an endpoint, a limit of the system.</summary>
    Failed = 2,
    /// <summary>Both sides use different types.</summary>
    TypeMismatch = 3,
    /// <summary>A configuration is wrong. The sentence has file, line and column.</summary>
    ConfigError = 4,
    /// <summary>The session, or what was made from it, has ended.</summary>
    Closed = 5,
    /// <summary>A lossless subscriber has no room. Nobody got the message.</summary>
    Full = 6,
    /// <summary>The timeout came first.</summary>
    TimedOut = 7,
    /// <summary>Waiting was refused, because this thread runs a callback that the wait could depend on.</summary>
    WouldDeadlock = 8,
    /// <summary>Larger than 1 GiB, and another session subscribes.</summary>
    TooLarge = 9,
    /// <summary>There is no memory.</summary>
    NoMemory = 10,
    /// <summary>There is nothing of this name or number.</summary>
    NotFound = 11,
    /// <summary>A parameter or a transform was refused.</summary>
    Refused = 12,
    /// <summary>No session serves that name.</summary>
    NoServer = 20,
    /// <summary>The handler failed. The sentence is its own.</summary>
    HandlerFailed = 21,
    /// <summary>The server died or left during the call.</summary>
    ServerGone = 22,
    /// <summary>The caller has cancelled the call.</summary>
    Cancelled = 23,
    /// <summary>A message could not be written or read as its type.</summary>
    NotWritable = 24,
    /// <summary>No transform has a frame of this name.</summary>
    UnknownFrame = 30,
    /// <summary>Both frames are known, but in separate trees.</summary>
    NotConnected = 31,
    /// <summary>Before the oldest transform that is remembered.</summary>
    TooOld = 32,
    /// <summary>After the newest transform.</summary>
    TooNew = 33
  }

  /// <summary>Thrown by all of the binding when the library refuses: <c>catch (HgrosException e) when
  /// (e.Code == Code.Full)</c>. What is disposed throws ObjectDisposedException.</summary>
  public sealed class HgrosException : Exception {
    /// <summary>The kind of the failure.</summary>
    public Code Code { get; }
    /// <summary>What went wrong, where, and how to mend it.</summary>
    public string Sentence { get; }

    internal HgrosException(Code code, string sentence)
      : base("hgros: " + Marshal.PtrToStringAnsi(Native.hgros_status_name((int)code)) + ": " + sentence) {
      Code = code;
      Sentence = sentence;
    }

    // The sentence is that of the last call of this thread, which has returned the status.
    internal static void Check(int status) {
      if (status != 0) throw Last(status);
    }

    internal static HgrosException Last(int status) =>
      new HgrosException((Code)status, Marshal.PtrToStringAnsi(Native.hgros_last_error()));
  }
}
