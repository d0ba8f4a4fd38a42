using System;
using System.Runtime.InteropServices;

namespace Hgros {
  /// <summary>Something that is watched until it or its session is disposed.</summary>
  public sealed class Watch : IDisposable {
    private static readonly Native.ParamCallback Changed = (user, path, yaml) => {
      var watch = Callbacks.Target<Watch>(user);
      string place = Marshal.PtrToStringAnsi(path);
      watch.session.Run("The callback of parameter \"" + place + "\"",
        () => watch.changed(place, Marshal.PtrToStringAnsi(yaml)));
    };

    private static readonly Native.PeerCallback Happened = (user, happened, peer, channel, reason) => {
      var watch = Callbacks.Target<Watch>(user);
      watch.session.Run("The callback for peers", () => watch.happened((PeerEvent)happened, Peer.From(peer),
        Marshal.PtrToStringAnsi(channel), Marshal.PtrToStringAnsi(reason)));
    };

    private readonly Session session;
    private Action<string, string> changed;
    private Action<PeerEvent, Peer, string, string> happened;
    private WatchHandle handle;

    private Watch(Session session) {
      this.session = session;
    }

    internal static Watch ForParams(Session session, ParamsHandle parameters, string path,
      Action<string, string> changed) {
      var watch = new Watch(session) { changed = changed ?? throw new ArgumentNullException(nameof(changed)) };
      Callbacks.Give(watch, user => Native.hgros_params_watch(parameters, Texts.Uncut(path), Changed, user,
        Callbacks.Release, out watch.handle));
      return session.Keep(watch);
    }

    internal static Watch ForPeers(Session session, SessionHandle opened,
      Action<PeerEvent, Peer, string, string> happened) {
      var watch = new Watch(session) { happened = happened ?? throw new ArgumentNullException(nameof(happened)) };
      Callbacks.Give(watch, user => Native.hgros_watch_peers(opened, Happened, user, Callbacks.Release,
        out watch.handle));
      return session.Keep(watch);
    }

    /// <summary>No call comes after it. Outside callbacks it waits for the running one.</summary>
    public void Dispose() {
      session.Forget(this);
      handle.Dispose();
    }
  }
}
