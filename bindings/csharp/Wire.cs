using System;
using System.IO;
using System.Runtime.InteropServices;

namespace Hgros {
  // Protobuf's wire format (protobuf.dev, "Encoding"): a tag, then a number or bytes with their length.
  internal static class Wire {
    internal const int Varint = 0, Fixed64 = 1, Bytes = 2, Fixed32 = 5;
  }

  internal sealed class WireWriter {
    private readonly MemoryStream stream = new MemoryStream();

    internal void Tag(int number, int wireType) => Number(Wire.Varint, (ulong)number << 3 | (uint)wireType);

    internal void Number(int wireType, ulong value) {
      if (wireType == Wire.Varint) {
        for (; value > 127; value >>= 7) stream.WriteByte((byte)(value | 128));
        stream.WriteByte((byte)value);
      } else {
        for (int size = wireType == Wire.Fixed64 ? 8 : 4; size > 0; --size, value >>= 8) stream.WriteByte((byte)value);
      }
    }

    internal void Bytes(byte[] data) {
      Number(Wire.Varint, (ulong)data.Length);
      stream.Write(data, 0, data.Length);
    }

    internal bool Empty => stream.Length == 0;

    internal byte[] ToArray() => stream.ToArray();
  }

  // Reads memory that outlives it. After Next, the field's value is read or skipped.
  internal unsafe struct WireReader {
    private byte* at;
    private readonly byte* end;

    internal int Field { get; private set; }
    internal int WireType { get; private set; }

    internal WireReader(byte* data, long size) {
      at = data;
      end = data + size;
      Field = WireType = 0;
    }

    internal bool AtEnd => at == end;

    internal bool Next() {
      if (AtEnd) return false;
      ulong tag = Number(Wire.Varint);
      Field = (int)(tag >> 3);
      WireType = (int)(tag & 7);
      return true;
    }

    internal ulong Number(int wireType) {
      ulong value = 0;
      if (wireType == Wire.Varint) {
        for (int shift = 0; shift < 70; shift += 7) {
          byte next = *Take(1);
          value |= (ulong)(next & 127) << shift;
          if (next < 128) return value;
        }
        throw new InvalidDataException("A number has more than ten bytes.");
      }
      if (wireType != Wire.Fixed64 && wireType != Wire.Fixed32)
        throw new InvalidDataException("A field has the wire type " + wireType + ".");
      int size = wireType == Wire.Fixed64 ? 8 : 4;
      byte* bytes = Take((ulong)size);
      for (int i = 0; i < size; ++i) value |= (ulong)bytes[i] << 8 * i;
      return value;
    }

    internal WireReader Nested() {
      ulong size = Number(Wire.Varint);
      return new WireReader(Take(size), (long)size);
    }

    internal byte[] Bytes() {
      WireReader nested = Nested();
      var bytes = new byte[nested.end - nested.at];
      Marshal.Copy((IntPtr)nested.at, bytes, 0, bytes.Length);
      return bytes;
    }

    internal void Skip() {
      if (WireType == Wire.Bytes) Nested();
      else Number(WireType);
    }

    private byte* Take(ulong size) {
      if (size > (ulong)(end - at)) throw new InvalidDataException("The message is cut off.");
      at += size;
      return at - size;
    }
  }
}
