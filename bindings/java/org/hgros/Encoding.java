package org.hgros;

/** How the bytes of a type are written. */
public enum Encoding {
  /** Only of received messages. */
  UNKNOWN,
  PROTOBUF,
  /** A format that both sides agreed on by the type's name. */
  CUSTOM,
  /** The bytes of a struct of numbers; only between equal layouts and byte orders. */
  PLAIN;

  static Encoding of(int number) {
    return number > 0 && number < values().length ? values()[number] : UNKNOWN;
  }
}
