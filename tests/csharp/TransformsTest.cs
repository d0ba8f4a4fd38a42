using System;
using System.Threading;
using Hgros;
using static Test;

public static class TransformsTest {
  [Test]
  public static void TransformsAreFoundByName() {
    using (var robot = new Session())
    using (var tool = new Session())
    using (Transforms sent = robot.OpenTransforms())
    using (Transforms seen = tool.OpenTransforms()) {
      sent.SetStatic("map", "base", new Transform(1, 2, 3));
      Transform found = seen.Wait("map", "base", 0, Patience);
      Equal("1 2 3 0 0 0 1", string.Join(" ", found.X, found.Y, found.Z, found.QX, found.QY, found.QZ, found.QW));
      long now = (DateTime.UtcNow - new DateTime(1970, 1, 1)).Ticks * 100;
      sent.Set("base", "arm", new Transform(0, 0, 1, now));
      found = sent.LookupAt("map", "arm", now);
      Equal("1 2 4", string.Join(" ", found.X, found.Y, found.Z));
      Equal(now, found.Stamp);
      Equal(4.0, sent.Lookup("map", "arm").Z);
      Contains("moon", Fails(Code.UnknownFrame, () => sent.Lookup("map", "moon")));
      Contains("moon", Fails(Code.TimedOut, () => seen.Wait("map", "moon", 0, TimeSpan.FromMilliseconds(20))));
      Fails(Code.Refused, () => sent.SetStatic("other", "base", new Transform(0, 0, 0)));
      Fails(Code.Failed, () => robot.OpenTransforms());
      Thread waiting = Run(() => Fails(Code.Closed, () => seen.Wait("map", "moon")));
      tool.End();
      Soon(waiting);
    }
  }
}
