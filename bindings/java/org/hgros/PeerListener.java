package org.hgros;

/** Gets the events of peers. */
@FunctionalInterface
public interface PeerListener {
  /** The channel is empty for the first two events, the reason for the first; otherwise it is a sentence. */
  void happened(PeerEvent event, Peer peer, String channel, String reason);
}
