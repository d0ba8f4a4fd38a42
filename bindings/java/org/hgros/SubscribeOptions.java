package org.hgros;

/** What a subscription begins with. The default keeps the 16 newest messages. */
public final class SubscribeOptions {
  String name;
  long keepLast;
  long keepAll;
  long keepAllBytes;

  /** For logs, tables and configuration; otherwise channel and number. */
  public SubscribeOptions name(String name) {
    this.name = name;
    return this;
  }

  /** Number of newest messages that may wait; older ones are dropped and counted. */
  public SubscribeOptions keepLast(long messages) {
    keepLast = Texts.count("keepLast", messages);
    return this;
  }

  /** Lossless, with room for this many. Publishers get {@link Code#FULL} meanwhile. */
  public SubscribeOptions keepAll(long messages) {
    keepAll = Texts.count("keepAll", messages);
    return this;
  }

  /** For keepAll: also at most about this many bytes; 0: no limit. */
  public SubscribeOptions keepAllBytes(long bytes) {
    keepAllBytes = Texts.count("keepAllBytes", bytes);
    return this;
  }
}
