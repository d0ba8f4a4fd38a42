package org.hgros;

import java.time.Instant;

/**
 * Where a message comes from.
 *
 * @param remote from another session
 * @param publisher the sender's session id
 * @param sequence counts the sender's messages on the channel
 * @param key names the message in all processes
 * @param publishTime the sender's wall clock; 1970 for messages of the same session
 */
public record MessageInfo(boolean remote, long publisher, long sequence, long key, Instant publishTime) {}
