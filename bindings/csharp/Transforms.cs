using System;
using System.Runtime.InteropServices;
using System.Threading;

namespace Hgros {
  /// <summary>p_target = rotation * p_source + translation.</summary>
  [StructLayout(LayoutKind.Sequential)] // That of the library.
  public struct Transform {
    /// <summary>Translation along x, in meters.</summary>
    public double X;
    /// <summary>Translation along y, in meters.</summary>
    public double Y;
    /// <summary>Translation along z, in meters.</summary>
    public double Z;
    /// <summary>Rotation: a unit quaternion.</summary>
    public double QX;
    /// <summary>Its y.</summary>
    public double QY;
    /// <summary>Its z.</summary>
    public double QZ;
    /// <summary>Its w: 1 for no rotation.</summary>
    public double QW;
    /// <summary>In ns: the time at which it holds; 0 if only static transforms connect the frames.</summary>
    public long Stamp;

    /// <summary>A translation without a rotation.</summary>
    public Transform(double x, double y, double z, long stamp = 0) {
      X = x;
      Y = y;
      Z = z;
      QX = QY = QZ = 0;
      QW = 1;
      Stamp = stamp;
    }
  }

  /// <summary>The transforms of a session: those it sets, which other sessions get, and those it receives.</summary>
  public sealed class Transforms : IDisposable {
    private readonly Session session; // Not forgotten while its transforms are used.
    private readonly TransformsHandle handle;

    internal Transforms(Session session, SessionHandle opened) {
      this.session = session;
      HgrosException.Check(Native.hgros_transforms_open(opened, out handle));
    }

    /// <summary>Sets and sends the pose of a child frame in its parent at the pose's stamp.</summary>
    public void Set(string parent, string child, Transform pose) =>
      HgrosException.Check(Native.hgros_transforms_set(handle, Texts.Uncut(parent), Texts.Uncut(child), ref pose));

    /// <summary>The same for a pose that does not move: sessions that join later get it, too.</summary>
    public void SetStatic(string parent, string child, Transform pose) =>
      HgrosException.Check(Native.hgros_transforms_set_static(handle, Texts.Uncut(parent), Texts.Uncut(child),
        ref pose));

    /// <summary>The transform from a source frame to a target at the latest time that all edges between them
    /// have.</summary>
    public Transform Lookup(string target, string source) {
      Transform found;
      HgrosException.Check(Native.hgros_transforms_lookup(handle, Texts.Uncut(target), Texts.Uncut(source), out found));
      return found;
    }

    /// <summary>The same at a time in ns.</summary>
    public Transform LookupAt(string target, string source, long time) {
      Transform found;
      HgrosException.Check(Native.hgros_transforms_lookup_at(handle, Texts.Uncut(target), Texts.Uncut(source),
        time, out found));
      return found;
    }

    /// <summary>The same, but waits until it is there. Code.TimedOut says why it is not there.</summary>
    public Transform Wait(string target, string source, long time = 0, TimeSpan? timeout = null,
      CancellationToken token = default) {
      Transform found = default;
      Waiting.Run(timeout, token,
        left => Native.hgros_transforms_wait(handle, Texts.Uncut(target), Texts.Uncut(source), time, left, out found));
      return found;
    }

    /// <summary>Sends what still waits. Inside a callback that happens when it has returned.</summary>
    public void Dispose() {
      handle.Dispose();
      GC.KeepAlive(session);
    }
  }

  public sealed partial class Session {
    /// <summary>Opens the transforms of the session, which has one at a time.</summary>
    public Transforms OpenTransforms() => new Transforms(this, handle);
  }
}
