using System;

namespace Hgros {
  // Checks of what the program gives, so that exceptions name it.
  internal static class Arguments {
    internal static T Given<T>(T argument, string name) where T : class =>
      argument ?? throw new ArgumentNullException(name);

    internal static ulong Count(long count, string name) =>
      count >= 0 ? (ulong)count : throw new ArgumentOutOfRangeException(name, count, "It must not be negative.");
  }
}
