package org.hgros;

/** The weight of a line of the log. */
public enum LogLevel {
  DEBUG,
  INFO,
  WARNING,
  ERROR;

  /** A newer library may have more: those above are errors, too. */
  static LogLevel of(int number) {
    return values()[Math.max(0, Math.min(number, values().length - 1))];
  }
}
