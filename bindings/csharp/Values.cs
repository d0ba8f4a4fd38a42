using System;
using System.Collections;
using System.Collections.Generic;
using System.Globalization;

namespace Hgros {
  // FieldDescriptorProto.Type of google/protobuf/descriptor.proto.
  internal enum Kind {
    Double = 1, Float, Int64, UInt64, Int32, Fixed64, Fixed32, Bool, String, Group, Message, Bytes, UInt32, Enum,
    SFixed32, SFixed64, SInt32, SInt64
  }

  // Values of protobuf's types as those of C#.
  internal static class Values {
    internal static int WireTypeOf(Kind kind) {
      switch (kind) {
        case Kind.Double: case Kind.Fixed64: case Kind.SFixed64: return Wire.Fixed64;
        case Kind.Float: case Kind.Fixed32: case Kind.SFixed32: return Wire.Fixed32;
        case Kind.String: case Kind.Bytes: case Kind.Message: return Wire.Bytes;
        default: return Wire.Varint;
      }
    }

    private static Type TypeOf(Kind kind) {
      switch (kind) {
        case Kind.Double: return typeof(double);
        case Kind.Float: return typeof(float);
        case Kind.Int64: case Kind.SFixed64: case Kind.SInt64: return typeof(long);
        case Kind.UInt64: case Kind.Fixed64: return typeof(ulong);
        case Kind.UInt32: case Kind.Fixed32: return typeof(uint);
        case Kind.Bool: return typeof(bool);
        case Kind.String: return typeof(string);
        case Kind.Bytes: return typeof(byte[]);
        case Kind.Message: return typeof(DynamicMessage);
        case Kind.Group: throw new NotSupportedException("Groups of protobuf are not supported.");
        default: return typeof(int);
      }
    }

    internal static IList ListOf(Kind kind) =>
      (IList)Activator.CreateInstance(typeof(List<>).MakeGenericType(TypeOf(kind)));

    internal static object DefaultOf(Kind kind) {
      if (kind == Kind.Message) return null;
      if (kind == Kind.Bytes) return new byte[0];
      return kind == Kind.String ? "" : Activator.CreateInstance(TypeOf(kind));
    }

    internal static object Convert(Field field, object value) {
      if (field.Kind == Kind.Message && (value as DynamicMessage)?.TypeName != field.Message.Name)
        throw new ArgumentException("The field \"" + field.Name + "\" must be a " + field.Message.Name + ".");
      if (TypeOf(field.Kind).IsInstanceOfType(value)) return value;
      return System.Convert.ChangeType(value, TypeOf(field.Kind), CultureInfo.InvariantCulture);
    }

    // A number of the wire as a value.
    internal static object FromNumber(Kind kind, ulong number) {
      switch (kind) {
        case Kind.Double: return BitConverter.Int64BitsToDouble((long)number);
        case Kind.Float: return BitConverter.ToSingle(BitConverter.GetBytes((uint)number), 0);
        case Kind.Int64: case Kind.SFixed64: return (long)number;
        case Kind.UInt64: case Kind.Fixed64: return number;
        case Kind.UInt32: case Kind.Fixed32: return (uint)number;
        case Kind.Bool: return number != 0;
        case Kind.SInt32: return (int)((uint)number >> 1) ^ -(int)(number & 1);
        case Kind.SInt64: return (long)(number >> 1) ^ -(long)(number & 1);
        default: return (int)number;
      }
    }

    internal static ulong ToNumber(Kind kind, object value) {
      switch (kind) {
        case Kind.Double: return (ulong)BitConverter.DoubleToInt64Bits((double)value);
        case Kind.Float: return BitConverter.ToUInt32(BitConverter.GetBytes((float)value), 0);
        case Kind.Int64: case Kind.SFixed64: return (ulong)(long)value;
        case Kind.UInt64: case Kind.Fixed64: return (ulong)value;
        case Kind.UInt32: case Kind.Fixed32: return (uint)value;
        case Kind.Bool: return (bool)value ? 1UL : 0;
        case Kind.SInt32: return (uint)((int)value << 1 ^ (int)value >> 31);
        case Kind.SInt64: return (ulong)((long)value << 1 ^ (long)value >> 63);
        default: return (ulong)(int)value;
      }
    }
  }
}
