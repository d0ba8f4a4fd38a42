package org.hgros;

/**
 * Another session.
 *
 * @param process its program's name
 * @param host its host's name, only shown, never compared
 * @param transport of its messages: "shared memory" or "ZeroMQ"
 * @param why why that transport was chosen
 */
public record Peer(long id, String process, String host, long pid, String transport, String why) {
  Peer(Structs.Peer peer) {
    this(peer.id, peer.process, peer.host, peer.pid, peer.transport, peer.why);
  }
}
