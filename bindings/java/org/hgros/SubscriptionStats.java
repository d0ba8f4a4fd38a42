package org.hgros;

/**
 * Counts since a subscription began.
 *
 * @param received messages that reached it, including those dropped later
 * @param dropped removed from a full keep-last queue
 * @param taken taken from the queue, also by callbacks
 * @param queued waiting now
 * @param mismatched not delivered: of another type
 * @param failed messages that could not be read, and callbacks that threw
 */
public record SubscriptionStats(long received, long dropped, long taken, long queued, long mismatched, long failed) {}
