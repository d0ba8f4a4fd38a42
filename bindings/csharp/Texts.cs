using System.Linq;
using System.Text;

namespace Hgros {
  // Texts that go to C, where a text is UTF-8 and ends at its first zero.
  internal static class Texts {
    private static readonly UTF8Encoding Strict = new UTF8Encoding(false, true);
    private static readonly UTF8Encoding Lenient = new UTF8Encoding(false, false);

    // The text, which may be null. Refuses one that C would cut, and one that is no UTF-8: Mono notices the latter only
    // after it has taken the handles of a call, and never gives them back.
    internal static string Uncut(string text) {
      if (text == null) return text;
      if (text.IndexOf('\0') >= 0) {
        throw new HgrosException(Code.InvalidArgument, "The text \"" + Readable(text).Replace("\0", "\\0") +
          "\" has the character U+0000, which no text here may have.");
      }
      if (!IsWhole(text)) {
        throw new HgrosException(Code.InvalidArgument,
          "The text \"" + Readable(text) + "\" has half a surrogate pair, which UTF-8 does not have. It was cut there.");
      }
      return text;
    }

    internal static string[] Uncut(string[] texts) => texts.Select(Uncut).ToArray();

    // For sentences of exceptions, which must not be refused.
    internal static string Mended(string text) => Readable(text).Replace('\0', ' ');

    // With U+FFFD for each half of a surrogate pair.
    private static string Readable(string text) => Lenient.GetString(Lenient.GetBytes(text));

    private static bool IsWhole(string text) {
      try {
        Strict.GetByteCount(text);
        return true;
      } catch (EncoderFallbackException) {
        return false;
      }
    }
  }
}
