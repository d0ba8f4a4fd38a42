package org.hgros;

import java.util.function.BiConsumer;

/** What a session is opened with. */
public final class SessionOptions {
  String name;
  BiConsumer<LogLevel, String> log;

  /** For logs and other sessions' tables; otherwise the program's name. */
  public SessionOptions name(String name) {
    this.name = name;
    return this;
  }

  /** Gets the log instead of standard error, one line at a time, on any thread. It must not call this package. */
  public SessionOptions log(BiConsumer<LogLevel, String> log) {
    this.log = log;
    return this;
  }
}
