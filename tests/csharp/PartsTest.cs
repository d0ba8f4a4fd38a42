using System;
using System.Collections.Concurrent;
using System.Globalization;
using System.IO;
using System.Threading;
using Hgros;
using static Test;

// Parameters and transforms.
public static class PartsTest {
  [Test]
  public static void ParametersAreDeclaredSetAndWatched() {
    CultureInfo.DefaultThreadCurrentCulture = Thread.CurrentThread.CurrentCulture = new CultureInfo("de-DE");
    string file = Path.GetTempFileName();
    File.WriteAllText(file, "wheel: {radius: 0.25}\n");
    using (var session = new Session())
    using (Params parameters = session.OpenParams(file)) {
      parameters.Declare("wheel.radius", 0.1, new ParamInfo { Unit = "m", Most = 1 });
      parameters.Declare("wheel.count", 4);
      parameters.Declare("name", "it's: \"mïne\"\n");
      parameters.Declare("gains", new[] { 1, 2.5 });
      parameters.Declare("on", true);
      parameters.Declare("mode", "slow", new ParamInfo { Choices = new[] { "slow", "fast" } });
      Equal(0.25, parameters.GetNumber("wheel.radius"));
      Equal(4L, parameters.GetInteger("wheel.count"));
      Equal("it's: \"mïne\"\n", parameters.GetText("name"));
      Equal("[1.0, 2.5]", parameters.GetYaml("gains"));
      Equal(true, parameters.GetBool("on"));
      var changes = new ConcurrentQueue<string>();
      Watch watch = parameters.OnChange("wheel", (path, yaml) => {
        changes.Enqueue(path + "=" + yaml);
        if (yaml == "3") throw new InvalidOperationException("no tricycles");
      });
      parameters.Set("wheel.radius", 0.5);
      parameters.Set("wheel.count", 3);
      parameters.Remove("wheel.count");
      Equal("wheel.radius=0.5 wheel.count=3 wheel.count=4", string.Join(" ", changes));
      Equal(1L, session.FailedCallbacks);
      Contains("1", Fails(Code.Refused, () => parameters.Set("wheel.radius", 2.0)));
      Fails(Code.Refused, () => parameters.Set("mode", "backwards"));
      Throws<ArgumentOutOfRangeException>(() => parameters.Set("gains", new[] { double.NaN }));
      watch.Dispose();
      parameters.SetYaml("wheel", "{radius: 0.75, count: 2}");
      Equal(3, changes.Count);
      parameters.Save();
      Contains("0.75", File.ReadAllText(file));
      parameters.Dispose();
      Throws<ObjectDisposedException>(() => parameters.GetBool("on"));
    }
    File.Delete(file);
  }

  [Test]
  public static void ParametersOfAnotherSession() {
    using (var robot = new Session("", new SessionOptions { Name = "robot" }))
    using (var tool = new Session())
    using (Params own = robot.OpenParams())
    using (Params theirs = tool.ParamsOf("robot", Patience)) {
      own.Declare("speed", 1);
      Until("the parameter can be set", () => {
        try {
          theirs.Set("speed", 7);
          return true;
        } catch (HgrosException failure) when (failure.Code == Code.Refused) {
          return false;
        }
      });
      Equal(7L, own.GetInteger("speed"));
      Equal(7L, theirs.GetInteger("speed"));
    }
  }

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
