using System;
using System.Collections;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Runtime.InteropServices;

namespace Hgros {
  /// <summary>A protobuf type that is known by its description alone, without a generated class.</summary>
  public sealed class DynamicType : MessageType<DynamicMessage> {
    private static readonly ConcurrentDictionary<Tuple<string, ulong>, DynamicType> received =
      new ConcurrentDictionary<Tuple<string, ulong>, DynamicType>();

    internal Descriptor Descriptor { get; }

    /// <summary>The type of a schema, such as that of a received message.</summary>
    public DynamicType(Schema schema) : this(schema, Descriptor.Of(schema)) {}

    private unsafe DynamicType(Schema schema, Descriptor descriptor)
      : base(schema, message => message.Write(descriptor),
        stream => new DynamicMessage(descriptor, new WireReader(stream.PositionPointer, stream.Length))) {
      Descriptor = descriptor;
    }

    /// <summary>A type that comes with the library, such as "foxglove.Log".</summary>
    public static DynamicType Known(string typeName) => new DynamicType(Schema.Known(typeName));

    // That of a received message, which is made once for each type.
    internal static DynamicType Of(IntPtr schema) =>
      received.GetOrAdd(
        Tuple.Create(Marshal.PtrToStringAnsi(Native.hgros_schema_type_name(schema)),
          Native.hgros_schema_fingerprint(schema)),
        key => new DynamicType(Schema.CopyOf(schema)));
  }

  /// <summary>A protobuf message whose type is known at run time. Fields are found by their names: numbers as those of
  /// C#, byte[], enums as int; repeated fields as a List of these, maps as a List of messages with `key` and `value`.
  /// What is set is written, in the order of the numbers; unknown fields are not kept.</summary>
  public sealed class DynamicMessage {
    private const int MostNested = 100; // As in other protobuf libraries.

    private readonly Descriptor descriptor;
    private readonly SortedDictionary<int, object> values = new SortedDictionary<int, object>();

    /// <summary>An empty message.</summary>
    public DynamicMessage(DynamicType type) : this(type.Descriptor) {}

    private DynamicMessage(Descriptor descriptor) {
      this.descriptor = descriptor;
    }

    internal DynamicMessage(Descriptor descriptor, WireReader wire) : this(descriptor) {
      Merge(wire, MostNested);
    }

    /// <summary>The full name of its type.</summary>
    public string TypeName => descriptor.Name;

    /// <summary>The value of a field; null for a message that is not set. Setting null clears the field.</summary>
    public object this[string name] {
      get {
        Field field = Find(name);
        object value;
        if (values.TryGetValue(field.Number, out value)) return value;
        return field.Repeated ? values[field.Number] = Values.ListOf(field.Kind) : Values.DefaultOf(field.Kind);
      }
      set {
        Field field = Find(name);
        values.Remove(field.Number);
        if (value != null && !field.Repeated) values[field.Number] = Values.Convert(field, value);
        else if (value != null)
          foreach (object element in (IEnumerable)value) ((IList)this[name]).Add(Values.Convert(field, element));
      }
    }

    /// <summary>The message in a field, which is made if it is not set; for a repeated field, one more.</summary>
    public DynamicMessage Make(string name) {
      Field field = Find(name);
      if (field.Kind != Kind.Message) throw new ArgumentException("\"" + name + "\" is no field of messages.");
      var made = field.Repeated ? null : (DynamicMessage)this[name];
      if (made != null) return made;
      made = new DynamicMessage(field.Message);
      if (field.Repeated) ((IList)this[name]).Add(made);
      else values[field.Number] = made;
      return made;
    }

    /// <summary>A line for each field, for people.</summary>
    public override string ToString() => string.Join("\n", values.SelectMany(entry => {
      Field field = descriptor.ByNumber[entry.Key];
      return Elements(field, entry.Value).Select(value => field.Name + ": " + (field.Kind == Kind.Message
        ? "{\n  " + value.ToString().Replace("\n", "\n  ") + "\n}"
        : value is byte[] ? ((byte[])value).Length + " bytes" : FormattableString.Invariant($"{value}")));
    }));

    private Field Find(string name) {
      Field field;
      if (descriptor.ByName.TryGetValue(name, out field)) return field;
      throw new KeyNotFoundException(TypeName + " has no field \"" + name + "\", but " +
        string.Join(", ", descriptor.ByName.Keys) + ".");
    }

    private static IEnumerable<object> Elements(Field field, object value) =>
      field.Repeated ? ((IList)value).Cast<object>() : new[] { value };

    private void Merge(WireReader wire, int depth) {
      if (depth == 0) throw new InvalidDataException("The messages are nested too deep.");
      while (wire.Next()) {
        Field field;
        if (!descriptor.ByNumber.TryGetValue(wire.Field, out field)) wire.Skip();
        else if (field.Kind == Kind.Message) Make(field.Name).Merge(wire.Nested(), depth - 1);
        else if (wire.WireType != Values.WireTypeOf(field.Kind) && wire.WireType == Wire.Bytes && field.Repeated)
          for (WireReader packed = wire.Nested(); !packed.AtEnd;) Put(field, ref packed);
        else Put(field, ref wire);
      }
    }

    private void Put(Field field, ref WireReader wire) {
      object value = field.Kind == Kind.Bytes ? wire.Bytes()
        : field.Kind == Kind.String ? System.Text.Encoding.UTF8.GetString(wire.Bytes())
        : Values.FromNumber(field.Kind, wire.Number(Values.WireTypeOf(field.Kind)));
      if (field.Repeated) ((IList)this[field.Name]).Add(value);
      else values[field.Number] = value;
    }

    internal byte[] Write(Descriptor expected) {
      if (expected.Name != TypeName) throw new InvalidDataException("It is a \"" + TypeName + "\".");
      var wire = new WireWriter();
      foreach (KeyValuePair<int, object> entry in values) {
        Field field = descriptor.ByNumber[entry.Key];
        var packed = new WireWriter();
        foreach (object value in Elements(field, entry.Value)) {
          if (!field.Packed) wire.Tag(field.Number, Values.WireTypeOf(field.Kind));
          if (field.Kind == Kind.Message) wire.Bytes(((DynamicMessage)value).Write(field.Message));
          else if (field.Kind == Kind.Bytes) wire.Bytes((byte[])value);
          else if (field.Kind == Kind.String) wire.Bytes(System.Text.Encoding.UTF8.GetBytes((string)value));
          else (field.Packed ? packed : wire).Number(Values.WireTypeOf(field.Kind), Values.ToNumber(field.Kind, value));
        }
        if (!field.Packed || packed.Empty) continue;
        wire.Tag(field.Number, Wire.Bytes);
        wire.Bytes(packed.ToArray());
      }
      return wire.ToArray();
    }
  }
}
