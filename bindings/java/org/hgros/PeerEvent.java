package org.hgros;

/** What has happened to a session. */
public enum PeerEvent {
  CAME,
  GONE,
  /** It uses a channel with another type. */
  TYPE_MISMATCH,
  /** It serves a name that is served. */
  SERVED_TWICE,
  /** Something that this version of the binding does not know. */
  UNKNOWN;

  static PeerEvent of(int number) {
    return number >= 0 && number < UNKNOWN.ordinal() ? values()[number] : UNKNOWN;
  }
}
