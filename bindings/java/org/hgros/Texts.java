package org.hgros;

import com.sun.jna.Pointer;
import com.sun.jna.StringArray;

/** Texts that go to C, where a text ends at its first zero. */
final class Texts {
  private Texts() {}

  /** The text, which may be null. Refuses one that C would cut. */
  static String checked(String what, String text) {
    if (text != null && text.indexOf('\0') >= 0) {
      throw new HgrosException(Code.INVALID_ARGUMENT,
          what + " is \"" + text.replace("\0", "\\0") + "\", but a text must not have the character U+0000.");
    }
    return text;
  }

  /** Texts in memory of C. */
  static Pointer list(String what, String... texts) {
    for (String text : texts) {
      checked(what, text);
    }
    return new StringArray(texts, "UTF-8");
  }
}
