package org.hgros;

/**
 * A channel that some session uses.
 *
 * @param name channels of the library itself begin with "hgros/"
 * @param typeName empty: unknown
 * @param fingerprint 0: unknown
 */
public record ChannelInfo(String name, String typeName, long fingerprint, Encoding encoding, long publishers,
    long subscribers) {}
