package org.hgros;

/** What a service is offered with. */
public final class ServeOptions {
  long mostWaiting;
  boolean concurrent;

  /** Number of requests that may wait; further ones fail with {@link Code#FULL}. Default: 16384. */
  public ServeOptions mostWaiting(long requests) {
    mostWaiting = Texts.count("mostWaiting", requests);
    return this;
  }

  /** Any number of requests may be handled at once. */
  public ServeOptions concurrent() {
    concurrent = true;
    return this;
  }
}
