using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Linq;
using Hgros;
using static Test;

// Messages that are read and written by their description, beside what protoc reads and writes.
public static class DynamicMessageTest {
  private static readonly string Folder = Environment.GetEnvironmentVariable("TEST_PROTOS");

  // What a program prints, which must succeed. Its path is in the environment.
  private static byte[] RunTool(string variable, string arguments, byte[] input = null) {
    using (Process process = Process.Start(new ProcessStartInfo {
      FileName = Environment.GetEnvironmentVariable(variable), Arguments = arguments, UseShellExecute = false,
      RedirectStandardInput = true, RedirectStandardOutput = true
    })) {
      process.StandardInput.BaseStream.Write(input ?? new byte[0], 0, input?.Length ?? 0);
      process.StandardInput.Close();
      var output = new MemoryStream();
      process.StandardOutput.BaseStream.CopyTo(output);
      process.WaitForExit();
      Equal(0, process.ExitCode);
      return output.ToArray();
    }
  }

  private static DynamicType TypeOf(string file, string name) => new DynamicType(Schema.Protobuf(name,
    RunTool("PROTOC", "-I " + Folder + " --include_imports --descriptor_set_out=/dev/stdout " + file)));

  private static byte[] Encode(string file, string name, string text) =>
    RunTool("PROTOC", "-I " + Folder + " --encode=" + name + " " + file, System.Text.Encoding.UTF8.GetBytes(text));

  // Through a channel, as a program does it.
  private static DynamicMessage Read(DynamicType type, byte[] bytes) {
    using (var session = new Session())
    using (var queue = session.Subscribe("messages", type))
    using (var publisher = session.Advertise("messages", type)) {
      publisher.Raw.Publish(bytes);
      return queue.Next();
    }
  }

  private static byte[] Write(DynamicType type, DynamicMessage message) {
    using (var session = new Session())
    using (var queue = session.Subscribe("messages", type))
    using (var publisher = session.Advertise("messages", type)) {
      publisher.Publish(message);
      using (Message written = queue.Raw.Take()) return written.ToArray();
    }
  }

  [Test]
  public static void ReadsAndWritesWhatProtocWrites() {
    DynamicType type = TypeOf("kinds.proto", "test.Kinds");
    byte[] encoded = Encode("kinds.proto", "test.Kinds", File.ReadAllText(Folder + "/kinds.txt"));
    DynamicMessage message = Read(type, encoded);
    Equal(-1.5, message["a_double"]);
    Equal(0.25f, message["a_float"]);
    Equal(long.MinValue, message["an_int64"]);
    Equal(ulong.MaxValue, message["a_uint64"]);
    Equal(-1, message["an_int32"]);
    Equal(ulong.MaxValue - 1, message["a_fixed64"]);
    Equal(uint.MaxValue, message["a_fixed32"]);
    Equal(true, message["a_bool"]);
    Equal("ä\n", message["a_string"]);
    var inner = (DynamicMessage)((DynamicMessage)((DynamicMessage)message["a_part"])["kinds"])["a_part"];
    Equal("test.Kinds.Part inner", inner.TypeName + " " + inner["name"]);
    Equal("0 255", string.Join(" ", (byte[])message["some_bytes"]));
    Equal(uint.MaxValue, message["a_uint32"]);
    Equal(-2, message["a_color"]);
    Equal(int.MinValue, message["an_sfixed32"]);
    Equal(long.MinValue, message["an_sfixed64"]);
    Equal(int.MinValue, message["an_sint32"]);
    Equal(long.MinValue, message["an_sint64"]);
    Equal("1 0 -0.5", string.Join(" ", (List<double>)message["doubles"]));
    Equal("1 -1 0", string.Join(" ", (List<int>)message["sints"]));
    Equal("a|", string.Join("|", (List<string>)message["strings"]));
    Equal("x|", string.Join("|", ((List<DynamicMessage>)message["parts"]).Select(part => part["name"])));
    Equal("0 -2", string.Join(" ", (List<int>)message["colors"]));
    var count = ((List<DynamicMessage>)message["counts"]).Single();
    Equal("k 7", count["key"] + " " + count["value"]);
    Contains("a_part: {\n  name: outer", message.ToString());
    Equal(BitConverter.ToString(encoded), BitConverter.ToString(Write(type, message)));
  }

  [Test]
  public static void ProtocReadsWhatIsSet() {
    DynamicType type = TypeOf("kinds.proto", "test.Kinds");
    var message = new DynamicMessage(type) {
      ["a_double"] = 1, ["a_string"] = "ü", ["some_bytes"] = new byte[] { 65 }, ["an_sint32"] = -3L,
      ["doubles"] = new[] { 1, 2 }, ["strings"] = new[] { "a", "b" }
    };
    message.Make("a_part").Make("kinds")["a_bool"] = true;
    message.Make("parts")["name"] = "x";
    ((List<double>)message["doubles"]).Add(3.5);
    Equal("a_double: 1\na_string: \"\\303\\274\"\na_part {\n  kinds {\n    a_bool: true\n  }\n}\nsome_bytes: \"A\"\n" +
      "an_sint32: -3\ndoubles: 1\ndoubles: 2\ndoubles: 3.5\nstrings: \"a\"\nstrings: \"b\"\n" +
      "parts {\n  name: \"x\"\n}\n",
      System.Text.Encoding.UTF8.GetString(RunTool("PROTOC", "-I " + Folder + " --decode=test.Kinds kinds.proto", Write(type, message))));
    message["a_part"] = null;
    Equal(null, message["a_part"]);
    Equal("", message.Make("a_part")["name"]);
  }

  [Test]
  public static void OldFilesPackOnlyWhatTheySay() {
    DynamicType type = TypeOf("old_kinds.proto", "test.old.Lists");
    byte[] encoded = Encode("old_kinds.proto", "test.old.Lists", "one: 0 loose: [1, -1] tight: [7, 8]");
    DynamicMessage message = Read(type, encoded);
    Equal("1 -1 7 8", string.Join(" ", (List<int>)message["loose"]) + " " +
      string.Join(" ", (List<uint>)message["tight"]));
    Equal(BitConverter.ToString(encoded), BitConverter.ToString(Write(type, message)));
  }

  [Test]
  public static void WrongValuesAreRefused() {
    DynamicType type = TypeOf("kinds.proto", "test.Kinds");
    var message = new DynamicMessage(type);
    Contains("a_double", Throws<KeyNotFoundException>(() => message["a_triple"] = 1).Message);
    Throws<FormatException>(() => message["a_double"] = "one");
    Throws<OverflowException>(() => message["an_int32"] = 1L << 40);
    Throws<InvalidCastException>(() => message["some_bytes"] = 1);
    Contains("test.Kinds.Part", Throws<ArgumentException>(() => message["a_part"] = message).Message);
    Throws<ArgumentException>(() => message.Make("a_bool"));
    Contains("test.Kinds", Fails(Code.NotWritable, () => Write(DynamicType.Known("foxglove.Log"), message)));
  }

  // The bytes of other programs may be anything.
  [Test]
  public static void WrongBytesAreRefused() {
    DynamicType type = TypeOf("kinds.proto", "test.Kinds");
    byte[] encoded = Encode("kinds.proto", "test.Kinds", File.ReadAllText(Folder + "/kinds.txt"));
    const int seed = 7;
    Console.WriteLine("seed " + seed);
    var random = new Random(seed);
    int refused = 0;
    using (var session = new Session())
    using (var queue = session.Subscribe("messages", type))
    using (var publisher = session.AdvertiseRaw("messages", type.Schema)) {
      for (int i = 0; i < 3000; ++i) {
        byte[] wrong = encoded.Take(random.Next(encoded.Length + 1)).ToArray();
        for (int changes = random.Next(4); changes > 0 && wrong.Length > 0; --changes)
          wrong[random.Next(wrong.Length)] = (byte)random.Next(256);
        publisher.Publish(wrong);
        try {
          queue.Next();
        } catch (HgrosException failure) when (failure.Code == Code.NotWritable) {
          ++refused;
        }
      }
      byte[] nested = new byte[0];
      for (int depth = 0; depth < 200; ++depth) nested = Nest(nested, depth % 2 == 0 ? 0x12 : 0x5a);
      publisher.Publish(nested);
      Contains("deep", Fails(Code.NotWritable, () => queue.Next()));
    }
    True(refused > 1000, refused + " of 3000 are refused");
    Equal(0UL, Message.Leases);
  }

  private static byte[] Nest(byte[] content, int tag) {
    var size = new List<byte>();
    int rest = content.Length;
    for (; rest > 127; rest >>= 7) size.Add((byte)(rest | 128));
    size.Add((byte)rest);
    return new[] { (byte)tag }.Concat(size).Concat(content).ToArray();
  }

  // The shape of a class that protoc generates for Google.Protobuf.
  private sealed class Generated {
    internal static readonly Parser Parse = new Parser();
    internal byte[] Content;

    internal byte[] ToByteArray() => Content;

    internal sealed class Parser {
      internal Generated ParseFrom(byte[] data) => new Generated { Content = data };
      internal Generated ParseFrom(Stream input) {
        var content = new MemoryStream();
        input.CopyTo(content);
        return new Generated { Content = content.ToArray() };
      }
    }
  }

  [Test]
  public static void GeneratedClassesJoinThroughTwoFunctions() {
    byte[] file = OnlyFile(RunTool("PROTOC", "-I " + Folder + " --descriptor_set_out=/dev/stdout kinds.proto"));
    var type = new MessageType<Generated>(Schema.Protobuf("test.Kinds", new[] { file }),
      message => message.ToByteArray(), Generated.Parse.ParseFrom);
    Equal(TypeOf("kinds.proto", "test.Kinds").Schema.Fingerprint, type.Schema.Fingerprint);
    using (var session = new Session())
    using (var queue = session.Subscribe("messages", type))
    using (var publisher = session.Advertise("messages", type)) {
      publisher.Publish(new Generated { Content = new byte[] { 1, 2 } });
      publisher.Publish(new Generated { Content = new byte[0] });
      Equal(2, queue.Next().Content.Length);
      Equal(0, queue.Next().Content.Length);
    }
  }

  // The one FileDescriptorProto of a set: behind a tag and its length.
  private static byte[] OnlyFile(byte[] set) => set.Skip(1).SkipWhile(letter => letter > 127).Skip(1).ToArray();
}
