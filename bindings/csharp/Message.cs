using System;
using System.IO;
using System.Runtime.InteropServices;

namespace Hgros {
  /// <summary>Where a message comes from.</summary>
  public struct MessageInfo {
    /// <summary>From another session.</summary>
    public bool Remote { get; internal set; }
    /// <summary>The sender's session id.</summary>
    public ulong Publisher { get; internal set; }
    /// <summary>Counts the sender's messages on the channel.</summary>
    public ulong Sequence { get; internal set; }
    /// <summary>Names the message in all processes.</summary>
    public ulong Key { get; internal set; }
    /// <summary>The sender's wall clock, in ns since 1970; 0 for messages of the same session.</summary>
    public long PublishTime { get; internal set; }
  }

  // A lease on the bytes of a message. What reads through it holds it, so none reads what is freed.
  internal sealed class MessageLease : SafeBuffer {
    private readonly IntPtr message;

    internal MessageLease(IntPtr message) : base(true) {
      this.message = message;
      UIntPtr size;
      SetHandle(Native.hgros_message_data(message, out size));
      Initialize((ulong)size);
    }

    public override bool IsInvalid => message == IntPtr.Zero; // An empty message may have no address.

    protected override bool ReleaseHandle() {
      Native.hgros_message_free(message);
      return true;
    }

    // Calls `use` with the message and the address of its bytes.
    internal T With<T>(Func<IntPtr, IntPtr, T> use) {
      bool held = false;
      try {
        DangerousAddRef(ref held);
        return use(message, handle);
      } finally {
        if (held) DangerousRelease();
      }
    }
  }

  /// <summary>A received message. Its bytes are the sender's memory, which is lent until the message is disposed:
  /// dispose it soon. One that is forgotten is disposed by the garbage collector.</summary>
  public sealed class Message : IDisposable {
    private readonly MessageLease lease;

    internal Message(IntPtr message) {
      lease = new MessageLease(message);
    }

    // A message of a callback, which is the library's until the callback returns.
    internal static Message Keep(IntPtr message) {
      IntPtr kept;
      HgrosException.Check(Native.hgros_message_keep(message, out kept));
      return new Message(kept);
    }

    /// <summary>The number of messages of this process that are not yet disposed.</summary>
    public static ulong Leases => Native.hgros_message_leases();

    /// <summary>The number of bytes.</summary>
    public long Size => (long)lease.ByteLength;

    /// <summary>The address of the bytes, which nobody may write. It is valid as long as the message, which the
    /// program must keep meanwhile (GC.KeepAlive). OpenRead has no such rule.</summary>
    public IntPtr Data => lease.With((message, data) => data);

    /// <summary>The bytes without a copy. Reading throws once the message is disposed.</summary>
    public UnmanagedMemoryStream OpenRead() =>
      lease.With((message, data) => new UnmanagedMemoryStream(lease, 0, Size, FileAccess.Read));

    /// <summary>A copy of the bytes.</summary>
    public byte[] ToArray() {
      var copy = new byte[Size];
      CopyTo(copy, 0);
      return copy;
    }

    /// <summary>Copies all bytes into an array.</summary>
    public void CopyTo(byte[] array, int start) => lease.With((message, data) => {
      Marshal.Copy(data, array, start, (int)Size);
      return true;
    });

    /// <summary>A copy of the type that came with the channel.</summary>
    public Schema Schema =>
      lease.With((message, data) => Schema.CopyOf(Native.hgros_message_schema(message)));

    /// <summary>Where the message comes from.</summary>
    public MessageInfo Info => lease.With((message, data) => {
      var info = new Native.MessageInfo { Size = Native.SizeOf<Native.MessageInfo>() };
      HgrosException.Check(Native.hgros_message_get_info(message, ref info));
      return new MessageInfo {
        Remote = info.Remote != 0, Publisher = info.Publisher, Sequence = info.Sequence, Key = info.Key,
        PublishTime = info.PublishTime
      };
    });

    /// <summary>Reads the message as its type. Code.TypeMismatch if it is of another one.</summary>
    public T Read<T>(MessageType<T> type) => lease.With((message, data) => {
      string came = Marshal.PtrToStringAnsi(
        Native.hgros_schema_type_name(Native.hgros_message_schema(message)));
      if (came != type.Schema.TypeName)
        throw new HgrosException(Code.TypeMismatch,
          "The message is a \"" + came + "\", but is read as \"" + type.Schema.TypeName + "\".");
      return type.Read(data, Size);
    });

    /// <summary>Reads the message with the type that came with the channel.</summary>
    public DynamicMessage Decode() =>
      Read(lease.With((message, data) => DynamicType.Of(Native.hgros_message_schema(message))));

    /// <summary>Another lease on the same bytes, without a copy: keeps what a callback gets beyond its end.</summary>
    public Message Keep() => lease.With((message, data) => Keep(message));

    /// <summary>Ends the lease.</summary>
    public void Dispose() => lease.Dispose();
  }
}
