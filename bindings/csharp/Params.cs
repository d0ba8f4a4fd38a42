using System;
using System.Globalization;
using System.Linq;
using System.Runtime.InteropServices;
using System.Text;

namespace Hgros {
  /// <summary>Describes a parameter that is declared.</summary>
  public sealed class ParamInfo {
    /// <summary>A sentence for people.</summary>
    public string Description { get; set; }
    /// <summary>Such as "m/s".</summary>
    public string Unit { get; set; }
    /// <summary>Keeps the value from the start of the program.</summary>
    public bool ReadOnly { get; set; }
    /// <summary>The lower bound of a number, or of each number of a list; included.</summary>
    public double? Least { get; set; }
    /// <summary>The upper bound.</summary>
    public double? Most { get; set; }
    /// <summary>What a text may be.</summary>
    public string[] Choices { get; set; }
  }

  /// <summary>A tree of parameters. A path is written like slam.matcher.gains[2]; values are YAML.</summary>
  public sealed class Params : IDisposable {
    private enum Kind {
      Bool,
      Integer,
      Number,
      Text,
      Numbers
    }

    private readonly Session session; // Not forgotten while its parameters are used.
    private readonly ParamsHandle handle;

    internal Params(Session session, ParamsHandle handle) {
      this.session = session;
      this.handle = handle;
    }

    /// <summary>Gives a parameter its kind and bounds, and the value that it has if it was never set.</summary>
    public void Declare(string path, bool fallback, ParamInfo info = null) =>
      Declare(path, Kind.Bool, fallback ? "true" : "false", info);
    /// <summary>The same for an integer.</summary>
    public void Declare(string path, long fallback, ParamInfo info = null) =>
      Declare(path, Kind.Integer, fallback.ToString(CultureInfo.InvariantCulture), info);
    /// <summary>The same for a number.</summary>
    public void Declare(string path, double fallback, ParamInfo info = null) =>
      Declare(path, Kind.Number, Yaml(fallback), info);
    /// <summary>The same for a text.</summary>
    public void Declare(string path, string fallback, ParamInfo info = null) =>
      Declare(path, Kind.Text, Yaml(Texts.Uncut(fallback)), info);
    /// <summary>The same for a list of numbers.</summary>
    public void Declare(string path, double[] fallback, ParamInfo info = null) =>
      Declare(path, Kind.Numbers, Yaml(fallback), info);

    private void Declare(string path, Kind kind, string fallback, ParamInfo info) {
      var chosen = new Native.ParamInfo {
        Size = Native.SizeOf<Native.ParamInfo>(), ReadOnly = info != null && info.ReadOnly ? 1 : 0,
        Description = Texts.Uncut(info?.Description), Unit = Texts.Uncut(info?.Unit),
        HasLeast = info?.Least == null ? 0 : 1, Least = info?.Least ?? 0,
        HasMost = info?.Most == null ? 0 : 1, Most = info?.Most ?? 0
      };
      IntPtr[] choices = Texts.Uncut(info?.Choices ?? new string[0]).Select(Marshal.StringToHGlobalAnsi).ToArray();
      GCHandle pinned = GCHandle.Alloc(choices, GCHandleType.Pinned);
      try {
        chosen.Choices = pinned.AddrOfPinnedObject();
        chosen.ChoiceCount = (UIntPtr)(uint)choices.Length;
        HgrosException.Check(Native.hgros_params_declare(handle, Texts.Uncut(path), (int)kind, fallback, ref chosen));
      } finally {
        pinned.Free();
        foreach (IntPtr choice in choices) Marshal.FreeHGlobal(choice);
      }
    }

    /// <summary>Reads a value.</summary>
    public bool GetBool(string path) {
      int value;
      HgrosException.Check(Native.hgros_params_get_bool(handle, Texts.Uncut(path), out value));
      return value != 0;
    }

    /// <summary>Reads a value.</summary>
    public long GetInteger(string path) {
      long value;
      HgrosException.Check(Native.hgros_params_get_integer(handle, Texts.Uncut(path), out value));
      return value;
    }

    /// <summary>Reads a value.</summary>
    public double GetNumber(string path) {
      double value;
      HgrosException.Check(Native.hgros_params_get_number(handle, Texts.Uncut(path), out value));
      return value;
    }

    /// <summary>Reads a value.</summary>
    public string GetText(string path) {
      IntPtr value;
      HgrosException.Check(Native.hgros_params_get_text(handle, Texts.Uncut(path), out value));
      return Taken(value);
    }

    /// <summary>Reads any value as YAML. An empty path is the whole tree.</summary>
    public string GetYaml(string path) {
      IntPtr yaml;
      HgrosException.Check(Native.hgros_params_get(handle, Texts.Uncut(path), out yaml));
      return Taken(yaml);
    }

    private static string Taken(IntPtr text) {
      string taken = Marshal.PtrToStringAnsi(text);
      Native.hgros_text_free(text);
      return taken;
    }

    /// <summary>Sets a value. Code.Refused says why it cannot be that.</summary>
    public void Set(string path, bool value) =>
      HgrosException.Check(Native.hgros_params_set_bool(handle, Texts.Uncut(path), value ? 1 : 0));
    /// <summary>The same for an integer.</summary>
    public void Set(string path, long value) =>
      HgrosException.Check(Native.hgros_params_set_integer(handle, Texts.Uncut(path), value));
    /// <summary>The same for a number.</summary>
    public void Set(string path, double value) =>
      HgrosException.Check(Native.hgros_params_set_number(handle, Texts.Uncut(path), value));
    /// <summary>The same for a text.</summary>
    public void Set(string path, string value) =>
      HgrosException.Check(Native.hgros_params_set_text(handle, Texts.Uncut(path), Texts.Uncut(value)));
    /// <summary>The same for a list of numbers.</summary>
    public void Set(string path, double[] value) => SetYaml(path, Yaml(value));
    /// <summary>Sets a value as YAML, such as "{x: 1}".</summary>
    public void SetYaml(string path, string yaml) =>
      HgrosException.Check(Native.hgros_params_set(handle, Texts.Uncut(path), Texts.Uncut(yaml)));

    /// <summary>Removes a value; a declared parameter returns to its fallback.</summary>
    public void Remove(string path) => HgrosException.Check(Native.hgros_params_remove(handle, Texts.Uncut(path)));

    /// <summary>Writes what was set at run time into the files of this program.</summary>
    public void Save() => HgrosException.Check(Native.hgros_params_save(handle));

    /// <summary>Calls a function for each changed value at, below or above a path, with its YAML, or null if it was
    /// removed. It runs on the thread that makes the change; for another session on a worker, first with all
    /// current values.</summary>
    public Watch OnChange(string path, Action<string, string> changed) =>
      Watch.ForParams(session, handle, path, changed);

    /// <summary>Ends the parameters. Inside a callback that happens when it has returned.</summary>
    public void Dispose() => handle.Dispose();

    private static string Yaml(double number) {
      if (double.IsNaN(number) || double.IsInfinity(number))
        throw new ArgumentOutOfRangeException(nameof(number), "A parameter must be finite.");
      return number.ToString("R", CultureInfo.InvariantCulture);
    }

    private static string Yaml(double[] numbers) => "[" + string.Join(", ", numbers.Select(Yaml)) + "]";

    private static string Yaml(string text) {
      var quoted = new StringBuilder("\"");
      foreach (char letter in text) {
        if (letter == '"' || letter == '\\') quoted.Append('\\').Append(letter);
        else if (letter < ' ') quoted.Append("\\x").Append(((int)letter).ToString("x2"));
        else quoted.Append(letter);
      }
      return quoted.Append('"').ToString();
    }
  }

  public sealed partial class Session {
    /// <summary>Reads the parameters of this program from YAML files, later ones over earlier ones. Other sessions
    /// may read, watch and set them under the session's name.</summary>
    public Params OpenParams(params string[] files) {
      ParamsHandle opened;
      HgrosException.Check(
        Native.hgros_params_open(handle, Texts.Uncut(files), (UIntPtr)(uint)files.Length, out opened));
      return new Params(this, opened);
    }

    /// <summary>The parameters that a session offers under its name. Each function asks that session, and waits at
    /// most the timeout.</summary>
    public Params ParamsOf(string name, TimeSpan timeout) {
      ParamsHandle opened;
      HgrosException.Check(
        Native.hgros_params_of(handle, Texts.Uncut(name), Waiting.Nanoseconds(timeout), out opened));
      return new Params(this, opened);
    }
  }
}
