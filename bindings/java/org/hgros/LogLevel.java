package org.hgros;

/** The weight of a line of the log. */
public enum LogLevel {
  DEBUG,
  INFO,
  WARNING,
  ERROR
}
