using System.Linq;

namespace Hgros {
  // Texts that go to C, where a text ends at its first zero.
  internal static class Texts {
    // The text, which may be null. Refuses one that C would cut.
    internal static string Uncut(string text) {
      if (text == null || text.IndexOf('\0') < 0) return text;
      throw new HgrosException(Code.InvalidArgument,
        "The text \"" + text.Replace("\0", "\\0") + "\" has the character U+0000, which no text here may have.");
    }

    internal static string[] Uncut(string[] texts) => texts.Select(Uncut).ToArray();

    // For sentences of exceptions, which must not be refused.
    internal static string WithoutZeros(string text) => text.Replace('\0', ' ');
  }
}
