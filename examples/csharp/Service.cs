using System;
using Hgros;

// Serves the length of a vector, and calls it twice: once with a vector that has none.
internal static class Service {
  private static readonly DynamicType Vector = DynamicType.Known("foxglove.Vector3");
  private static readonly DynamicType Log = DynamicType.Known("foxglove.Log");

  private static DynamicMessage Length(DynamicMessage vector) {
    double x = (double)vector["x"], y = (double)vector["y"];
    if (x == 0 && y == 0) throw new ArgumentException("The vector is zero.");
    return new DynamicMessage(Log) { ["message"] = "The length is " + Math.Sqrt(x * x + y * y) };
  }

  private static void Main() {
    using (var session = new Session())
    using (session.Serve("length", Vector, Log, Length)) {
      foreach (double y in new[] { 4.0, 0.0 }) {
        try {
          var vector = new DynamicMessage(Vector) { ["x"] = y * 3 / 4, ["y"] = y };
          Console.WriteLine(session.Call("length", Vector, Log, vector, TimeSpan.FromMinutes(1))["message"]);
        } catch (HgrosException failure) when (failure.Code == Code.HandlerFailed) {
          Console.WriteLine(failure.Message);
        }
      }
    }
  }
}
