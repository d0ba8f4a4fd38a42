using System;
using System.Collections.Generic;
using System.IO;
using System.Runtime.InteropServices;

namespace Hgros {
  /// <summary>How the bytes of a type are written.</summary>
  public enum Encoding {
    /// <summary>Of received messages only.</summary>
    Unknown = 0,
    /// <summary>The type's name is its full protobuf name.</summary>
    Protobuf = 1,
    /// <summary>A format that both sides agreed on by the type's name.</summary>
    Custom = 2,
    /// <summary>The bytes of a struct of numbers.</summary>
    Plain = 3
  }

  /// <summary>The type of messages: a name, an encoding and, for protobuf, a description. It never changes.</summary>
  public sealed class Schema {
    internal readonly SchemaHandle Handle;

    /// <summary>The full name of the type.</summary>
    public string TypeName { get; }
    /// <summary>How its bytes are written.</summary>
    public Encoding Encoding { get; }
    /// <summary>Equal for equal types; 0: unknown.</summary>
    public ulong Fingerprint { get; }

    private Schema(int status, SchemaHandle handle) {
      HgrosException.Check(status);
      Handle = handle;
      IntPtr schema = handle.DangerousGetHandle();
      TypeName = Marshal.PtrToStringAnsi(Native.hgros_schema_type_name(schema));
      Encoding = (Encoding)Native.hgros_schema_encoding(schema);
      Fingerprint = Native.hgros_schema_fingerprint(schema);
      GC.KeepAlive(handle);
    }

    private static Schema Create(string typeName, Encoding encoding, ulong fingerprint, byte[] set) {
      SchemaHandle handle;
      int status = Native.hgros_schema_create(Texts.Uncut(typeName), (int)encoding, fingerprint, set,
        (UIntPtr)(ulong)(set?.LongLength ?? 0), out handle);
      return new Schema(status, handle);
    }

    /// <summary>A type that comes with the library, such as "foxglove.Log".</summary>
    public static Schema Known(string typeName) {
      SchemaHandle handle;
      int status = Native.hgros_schema_known(Texts.Uncut(typeName), out handle);
      return new Schema(status, handle);
    }

    /// <summary>A protobuf type, with the google.protobuf.FileDescriptorSet that <c>protoc --include_imports
    /// --descriptor_set_out=FILE</c> writes.</summary>
    public static Schema Protobuf(string typeName, byte[] descriptorSet) =>
      Create(typeName, Encoding.Protobuf, 0, descriptorSet);

    /// <summary>A protobuf type, with the serialized google.protobuf.FileDescriptorProto of its file and of all
    /// imports, dependencies first, as generated classes have them.</summary>
    public static Schema Protobuf(string typeName, IEnumerable<byte[]> files) {
      var set = new WireWriter();
      foreach (byte[] file in files) {
        set.Tag(1, Wire.Bytes);
        set.Bytes(file);
      }
      return Protobuf(typeName, set.ToArray());
    }

    /// <summary>A type of your own whose bytes the library does not know. With fingerprint 0, types are compared
    /// by name and encoding alone.</summary>
    public static Schema Raw(string typeName, Encoding encoding = Encoding.Custom, ulong fingerprint = 0) =>
      Create(typeName, encoding, fingerprint, null);

    // A copy of the schema of a message.
    internal static Schema CopyOf(IntPtr schema) =>
      Create(Marshal.PtrToStringAnsi(Native.hgros_schema_type_name(schema)),
        (Encoding)Native.hgros_schema_encoding(schema), Native.hgros_schema_fingerprint(schema),
        DescriptorSetOf(schema));

    /// <summary>The serialized google.protobuf.FileDescriptorSet of a protobuf type; null if there is none.</summary>
    public byte[] DescriptorSet() {
      byte[] set = DescriptorSetOf(Handle.DangerousGetHandle());
      GC.KeepAlive(this);
      return set;
    }

    private static byte[] DescriptorSetOf(IntPtr schema) {
      UIntPtr size;
      IntPtr data = Native.hgros_schema_descriptor_set(schema, out size);
      if (data == IntPtr.Zero) return null;
      var set = new byte[(int)size];
      Marshal.Copy(data, set, 0, set.Length);
      return set;
    }
  }

  /// <summary>How messages of a class become bytes and back: what joins a protobuf library to the binding.</summary>
  public class MessageType<T> {
    private readonly Func<T, byte[]> write;
    private readonly Func<UnmanagedMemoryStream, T> read;

    /// <summary>The type on the channel.</summary>
    public Schema Schema { get; }

    /// <summary>The stream that `read` gets is the sender's memory. It ends when `read` returns.</summary>
    public MessageType(Schema schema, Func<T, byte[]> write, Func<UnmanagedMemoryStream, T> read) {
      Schema = schema ?? throw new ArgumentNullException(nameof(schema));
      this.write = write ?? throw new ArgumentNullException(nameof(write));
      this.read = read ?? throw new ArgumentNullException(nameof(read));
    }

    internal byte[] Write(T message) {
      try {
        return write(message) ?? throw new InvalidDataException("There are no bytes.");
      } catch (Exception exception) when (!(exception is HgrosException)) {
        throw new HgrosException(Code.NotWritable,
          "The message cannot be written as \"" + Schema.TypeName + "\": " + exception.Message);
      }
    }

    internal unsafe T Read(IntPtr data, long size) {
      try {
        byte nothing; // An empty message may have no address.
        using (var stream = new UnmanagedMemoryStream(size == 0 ? &nothing : (byte*)data, size)) return read(stream);
      } catch (Exception exception) when (!(exception is HgrosException)) {
        throw new HgrosException(Code.NotWritable,
          "The message cannot be read as \"" + Schema.TypeName + "\": " + exception.Message);
      }
    }
  }
}
