using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;

namespace Hgros {
  /// <summary>Another session.</summary>
  public sealed class Peer {
    /// <summary>Its session id.</summary>
    public ulong Id { get; private set; }
    /// <summary>Its program's name.</summary>
    public string Process { get; private set; }
    /// <summary>Its host's name. Only shown, never compared.</summary>
    public string Host { get; private set; }
    /// <summary>The number of its process.</summary>
    public long Pid { get; private set; }
    /// <summary>Of its messages: "shared memory" or "ZeroMQ".</summary>
    public string Transport { get; private set; }
    /// <summary>Why that transport was chosen.</summary>
    public string Why { get; private set; }

    internal static Peer From(Native.Peer peer) => new Peer {
      Id = peer.Id, Process = Marshal.PtrToStringAnsi(peer.Process), Host = Marshal.PtrToStringAnsi(peer.Host),
      Pid = peer.Pid, Transport = Marshal.PtrToStringAnsi(peer.Transport),
      Why = Marshal.PtrToStringAnsi(peer.Why)
    };

    internal static Peer From(IntPtr peer) => From(Marshal.PtrToStructure<Native.Peer>(peer));
  }

  /// <summary>What has happened to a session.</summary>
  public enum PeerEvent {
    /// <summary>It is connected.</summary>
    Came,
    /// <summary>It is gone; the reason is a sentence.</summary>
    Gone,
    /// <summary>It uses a channel with another type; the reason names both.</summary>
    TypeMismatch,
    /// <summary>It serves a name that is served.</summary>
    ServedTwice
  }

  /// <summary>A channel that some session uses.</summary>
  public sealed class Channel {
    /// <summary>Channels of the library itself begin with "hgros/".</summary>
    public string Name { get; private set; }
    /// <summary>Empty: unknown.</summary>
    public string TypeName { get; private set; }
    /// <summary>0: unknown.</summary>
    public ulong Fingerprint { get; private set; }
    /// <summary>How its bytes are written.</summary>
    public Encoding Encoding { get; private set; }
    /// <summary>The number of sessions that publish it.</summary>
    public int Publishers { get; private set; }
    /// <summary>The number of sessions that subscribe to it.</summary>
    public int Subscribers { get; private set; }

    internal static Channel From(Native.Channel channel) => new Channel {
      Name = Marshal.PtrToStringAnsi(channel.Name), TypeName = Marshal.PtrToStringAnsi(channel.TypeName),
      Fingerprint = channel.Fingerprint, Encoding = (Encoding)channel.Encoding,
      Publishers = (int)channel.Publishers, Subscribers = (int)channel.Subscribers
    };
  }

  public sealed partial class Session {
    /// <summary>The sessions that are connected with this one, at one moment.</summary>
    public IReadOnlyList<Peer> Peers() {
      IntPtr list;
      HgrosException.Check(Native.hgros_peers_open(handle, out list));
      try {
        var peers = new List<Peer>();
        for (uint i = 0; i < (uint)Native.hgros_peers_count(list); ++i) {
          var peer = new Native.Peer { Size = Native.SizeOf<Native.Peer>() };
          HgrosException.Check(Native.hgros_peers_get(list, (UIntPtr)i, ref peer));
          peers.Add(Peer.From(peer));
        }
        return peers;
      } finally {
        Native.hgros_peers_free(list);
      }
    }

    /// <summary>The channels of all sessions that are known, including the own, sorted by name, at one moment.
    /// </summary>
    public IReadOnlyList<Channel> Channels() {
      IntPtr list;
      HgrosException.Check(Native.hgros_channels_open(handle, out list));
      try {
        var channels = new List<Channel>();
        for (uint i = 0; i < (uint)Native.hgros_channels_count(list); ++i) {
          var channel = new Native.Channel { Size = Native.SizeOf<Native.Channel>() };
          HgrosException.Check(Native.hgros_channels_get(list, (UIntPtr)i, ref channel));
          channels.Add(Channel.From(channel));
        }
        return channels;
      } finally {
        Native.hgros_channels_free(list);
      }
    }

    /// <summary>Calls a function when a session comes or goes, uses a channel with another type, or serves a name
    /// that is served; one call at a time. It gets the event, the session, the channel, which is empty for the first
    /// two, and the reason, a sentence.</summary>
    public Watch OnPeer(Action<PeerEvent, Peer, string, string> happened) =>
      Watch.ForPeers(this, handle, happened);
  }
}
