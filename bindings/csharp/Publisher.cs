using System;
using System.IO;
using System.Runtime.InteropServices;
using System.Threading;

namespace Hgros {
  /// <summary>Publishes bytes of one type on one channel.</summary>
  public sealed class RawPublisher : IDisposable {
    private readonly PublisherHandle handle;
    private readonly Session session; // Not forgotten while its publisher is used.

    internal RawPublisher(Session session, PublisherHandle handle) {
      this.session = session;
      this.handle = handle;
    }

    /// <summary>Publishes a copy of the bytes. It never waits: Code.Full says that a lossless subscriber has no
    /// room.</summary>
    public void Publish(byte[] data) =>
      HgrosException.Check(
        Native.hgros_publish(handle, Arguments.Given(data, nameof(data)), (UIntPtr)(ulong)data.LongLength));

    /// <summary>Publishes a copy of the bytes, and waits while a lossless subscriber has no room.</summary>
    public void PublishWait(byte[] data, TimeSpan? timeout = null, CancellationToken token = default) {
      Arguments.Given(data, nameof(data));
      Waiting.Run(timeout, token,
        left => Native.hgros_publish_wait(handle, data, (UIntPtr)(ulong)data.LongLength, left));
    }

    /// <summary>Memory for one message, which receivers on this host read where it is.</summary>
    public Loan Lend(long size) {
      if (size < 0) throw new ArgumentOutOfRangeException(nameof(size), "The size must not be negative.");
      IntPtr loan;
      HgrosException.Check(Native.hgros_loan_open(handle, (UIntPtr)(ulong)size, out loan));
      return new Loan(session, loan);
    }

    /// <summary>Ends the publisher.</summary>
    public void Dispose() => handle.Dispose();
  }

  // The bytes of a loan, until it is published. What writes through it holds it.
  internal sealed class LoanMemory : SafeBuffer {
    internal readonly IntPtr Loan;

    internal LoanMemory(IntPtr loan) : base(true) {
      Loan = loan;
      UIntPtr size;
      SetHandle(Native.hgros_loan_data(loan, out size));
      Initialize((ulong)size);
    }

    public override bool IsInvalid => Loan == IntPtr.Zero;

    protected override bool ReleaseHandle() {
      Native.hgros_loan_free(Loan);
      return true;
    }
  }

  /// <summary>Memory to fill and publish without a copy. Used by one thread at a time.</summary>
  public sealed class Loan : IDisposable {
    private readonly LoanMemory memory;
    private readonly Session session;

    internal Loan(Session session, IntPtr loan) {
      this.session = session;
      memory = new LoanMemory(loan);
    }

    /// <summary>The number of bytes.</summary>
    public long Size => (long)memory.ByteLength;

    /// <summary>The address of the bytes, which have arbitrary values at first. It may be written until the loan is
    /// published or disposed, and the program must keep the loan meanwhile. OpenWrite has no such rule.</summary>
    public IntPtr Data => memory.IsClosed ? throw new ObjectDisposedException("Loan") : memory.DangerousGetHandle();

    /// <summary>The bytes as a stream. Writing throws once the loan is published or disposed.</summary>
    public UnmanagedMemoryStream OpenWrite() => new UnmanagedMemoryStream(memory, 0, Size, FileAccess.ReadWrite);

    /// <summary>Publishes the bytes, and waits while a lossless subscriber has no room. Then the loan is disposed. If
    /// this throws, the loan is as it was.</summary>
    public void Publish(TimeSpan? timeout = null, CancellationToken token = default) {
      bool held = false;
      try {
        memory.DangerousAddRef(ref held);
        Waiting.Run(timeout, token, left => Native.hgros_loan_publish(memory.Loan, left));
      } finally {
        if (held) memory.DangerousRelease();
      }
      Dispose();
    }

    /// <summary>Gives back what is not published.</summary>
    public void Dispose() {
      memory.Dispose();
      GC.KeepAlive(session);
    }
  }

  /// <summary>Publishes messages of a class on one channel.</summary>
  public sealed class Publisher<T> : IDisposable {
    private readonly MessageType<T> type;

    /// <summary>Publishes messages that are bytes already, and lends memory.</summary>
    public RawPublisher Raw { get; }

    internal Publisher(RawPublisher raw, MessageType<T> type) {
      Raw = raw;
      this.type = type;
    }

    /// <summary>Publishes a message. It never waits: Code.Full says that a lossless subscriber has no room.</summary>
    public void Publish(T message) => Raw.Publish(type.Write(message));

    /// <summary>Publishes a message, and waits while a lossless subscriber has no room.</summary>
    public void PublishWait(T message, TimeSpan? timeout = null, CancellationToken token = default) =>
      Raw.PublishWait(type.Write(message), timeout, token);

    /// <summary>Ends the publisher.</summary>
    public void Dispose() => Raw.Dispose();
  }

  public sealed partial class Session {
    /// <summary>Announces a channel of a type. `latched` is the number of recent messages kept for late
    /// subscribers.</summary>
    public RawPublisher AdvertiseRaw(string channel, Schema schema, int latched = 0) {
      Arguments.Given(schema, nameof(schema));
      var options = new Native.PublishOptions {
        Size = Native.SizeOf<Native.PublishOptions>(), Latched = Arguments.Count(latched, nameof(latched))
      };
      PublisherHandle publisher;
      HgrosException.Check(
        Native.hgros_publisher_open(handle, Texts.Uncut(channel), schema.Handle, ref options, out publisher));
      return new RawPublisher(this, publisher);
    }

    /// <summary>Announces a channel of a class of messages.</summary>
    public Publisher<T> Advertise<T>(string channel, MessageType<T> type, int latched = 0) =>
      new Publisher<T>(AdvertiseRaw(channel, Arguments.Given(type, nameof(type)).Schema, latched), type);
  }
}
