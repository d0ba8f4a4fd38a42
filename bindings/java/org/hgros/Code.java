package org.hgros;

/** The kind of a failure (hgros/c/status.h). */
public enum Code {
  /** A null where a value is needed, or a number outside its range. */
  INVALID_ARGUMENT(1),
  /** Wiring failed for another reason: a name, an endpoint, a limit of the system. */
  ERROR(2),
  /** Both sides use different types. The sentence names both. */
  TYPE_MISMATCH(3),
  /** A configuration is wrong. The sentence has file, line and column. */
  CONFIG_ERROR(4),
  /** The session, or what was made from it, has ended. */
  CLOSED(5),
  /** A lossless subscriber has no room, or too many calls wait. Nobody got the message. */
  FULL(6),
  TIMED_OUT(7),
  /** Waiting was refused: this thread runs a callback that the wait could depend on. */
  WOULD_DEADLOCK(8),
  /** Larger than 1 GiB, and another session subscribes. */
  TOO_LARGE(9),
  NO_MEMORY(10),
  NOT_FOUND(11),
  /** A parameter or a transform was refused. The sentence says why. */
  REFUSED(12),
  /** No session serves that name. */
  NO_SERVER(20),
  /** The handler failed. The sentence is its own. */
  HANDLER_FAILED(21),
  /** The server died or left during the call. */
  SERVER_GONE(22),
  CANCELLED(23),
  /** A message could not be written or read as its type. */
  NOT_WRITABLE(24),
  /** No transform has a frame of this name. */
  UNKNOWN_FRAME(30),
  /** Both frames are known, but in separate trees. */
  NOT_CONNECTED(31),
  /** Before the oldest transform that is remembered. */
  TOO_OLD(32),
  /** After the newest transform. */
  TOO_NEW(33),
  /** A number that this version of the binding does not know. */
  UNKNOWN(-1);

  final int status;

  Code(int status) {
    this.status = status;
  }

  static Code of(int status) {
    for (Code code : values()) {
      if (code.status == status) {
        return code;
      }
    }
    return UNKNOWN;
  }

  /** The name that all languages print, such as "full". */
  @Override
  public String toString() {
    return HgrosC.textAt(HgrosC.hgros_status_name(status));
  }
}
