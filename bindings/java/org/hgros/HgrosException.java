package org.hgros;

/** What every method of the package throws when the library refuses. */
public final class HgrosException extends RuntimeException {
  private static final long serialVersionUID = 1;

  private final Code code;

  HgrosException(Code code, String sentence) {
    super(sentence);
    this.code = code;
  }

  public Code code() {
    return code;
  }

  /**
   * The code's name, and the sentence, which {@link #getMessage} has alone: what went wrong, where, and how to mend it.
   */
  @Override
  public String toString() {
    return "hgros: " + code + ": " + getMessage();
  }
}
