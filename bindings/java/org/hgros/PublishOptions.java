package org.hgros;

/** What a channel is announced with. */
public final class PublishOptions {
  long latched;

  /** Number of recent messages kept for late subscribers. */
  public PublishOptions latched(long messages) {
    latched = Texts.count("latched", messages);
    return this;
  }
}
