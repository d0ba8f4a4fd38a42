using System.Collections.Generic;
using System.Linq;

namespace Hgros {
  internal sealed class Field {
    internal string Name, TypeName;
    internal int Number;
    internal Kind Kind;
    internal bool Repeated, Packed;
    internal Descriptor Message; // Of a field of messages.
  }

  // The fields of a message type.
  internal sealed class Descriptor {
    internal string Name;
    internal Dictionary<string, Field> ByName;
    internal Dictionary<int, Field> ByNumber;

    internal static unsafe Descriptor Of(Schema schema) {
      byte[] set = schema.DescriptorSet() ?? new byte[0];
      var types = new Dictionary<string, Descriptor>();
      fixed (byte* data = set)
        foreach (Part file in new Part(new WireReader(data, set.Length)).All(1)) {
          string package = file.Text(2);
          foreach (Part message in file.All(4)) Add(types, package == "" ? "" : "." + package, message, file.Text(12));
        }
      foreach (Field field in types.Values.SelectMany(type => type.ByNumber.Values))
        if (field.Kind == Kind.Message) types.TryGetValue(field.TypeName, out field.Message);
      Descriptor found;
      if (types.TryGetValue("." + schema.TypeName, out found)) return found;
      throw new HgrosException(Code.NotFound, "The type \"" + schema.TypeName + "\" has no protobuf description.");
    }

    private static void Add(Dictionary<string, Descriptor> types, string scope, Part message, string syntax) {
      string name = scope + "." + message.Text(1);
      List<Field> fields = message.All(2).Select(part => FieldOf(part, syntax)).ToList();
      types[name] = new Descriptor {
        Name = name.Substring(1), ByName = fields.ToDictionary(field => field.Name),
        ByNumber = fields.ToDictionary(field => field.Number)
      };
      foreach (Part nested in message.All(3)) Add(types, name, nested, syntax);
    }

    private static Field FieldOf(Part part, string syntax) {
      var kind = (Kind)part.Number(5, 0);
      bool repeated = part.Number(4, 0) == 3;
      ulong packed = syntax == "proto3" ? 1UL : 0; // Unless its options say something else.
      foreach (Part options in part.All(8)) packed = options.Number(2, packed);
      return new Field {
        Name = part.Text(1), Number = (int)part.Number(3, 0), Kind = kind, TypeName = part.Text(6), Repeated = repeated,
        Packed = repeated && packed != 0 && Values.WireTypeOf(kind) != Wire.Bytes
      };
    }

    // A message of google/protobuf/descriptor.proto, whose fields are known by their numbers there.
    private struct Part {
      private readonly WireReader wire;

      internal Part(WireReader wire) {
        this.wire = wire;
      }

      internal List<Part> All(int field) {
        var parts = new List<Part>();
        for (WireReader at = wire; at.Next();) {
          if (at.Field == field) parts.Add(new Part(at.Nested()));
          else at.Skip();
        }
        return parts;
      }

      internal string Text(int field) {
        for (WireReader at = wire; at.Next(); at.Skip())
          if (at.Field == field) return System.Text.Encoding.UTF8.GetString(at.Bytes());
        return "";
      }

      internal ulong Number(int field, ulong otherwise) {
        for (WireReader at = wire; at.Next(); at.Skip())
          if (at.Field == field) return at.Number(at.WireType);
        return otherwise;
      }
    }
  }
}
