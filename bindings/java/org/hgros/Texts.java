package org.hgros;

import com.sun.jna.Pointer;
import com.sun.jna.StringArray;

/** What goes to C, where a text is UTF-8 and ends at its first zero, and numbers of things have no sign. */
final class Texts {
  private Texts() {}

  /** The text, which may be null. Refuses one that C would cut or get otherwise. */
  static String checked(String what, String text) {
    if (text != null && text.indexOf('\0') >= 0) {
      throw new HgrosException(Code.INVALID_ARGUMENT,
          what + " is \"" + text.replace("\0", "\\0") + "\", but a text must not have the character U+0000.");
    }
    if (text != null && text.codePoints().anyMatch(point -> point >= 0xd800 && point < 0xe000)) {
      throw new HgrosException(Code.INVALID_ARGUMENT,
          what + " is \"" + text + "\", but has half a surrogate pair, which UTF-8 does not have. It was cut there.");
    }
    return text;
  }

  /** A number of things, which C takes for a huge one if it is below zero. */
  static long count(String what, long number) {
    if (number < 0) {
      throw new HgrosException(Code.INVALID_ARGUMENT, what + " is " + number + ", but must not be negative.");
    }
    return number;
  }

  /** Texts in memory of C. */
  static Pointer list(String what, String... texts) {
    for (String text : texts) {
      checked(what, text);
    }
    return new StringArray(texts, "UTF-8");
  }
}
