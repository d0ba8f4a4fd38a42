package org.hgros;

import com.google.protobuf.DescriptorProtos.FileDescriptorProto;
import com.google.protobuf.DescriptorProtos.FileDescriptorSet;
import com.google.protobuf.Descriptors.Descriptor;
import com.google.protobuf.Descriptors.DescriptorValidationException;
import com.google.protobuf.Descriptors.FileDescriptor;
import com.google.protobuf.InvalidProtocolBufferException;
import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.WeakHashMap;
import java.util.concurrent.ConcurrentHashMap;

/** The type of messages. Never changes. */
public final class Schema {
  private static final Map<Descriptor, Schema> OF_DESCRIPTORS = Collections.synchronizedMap(new WeakHashMap<>());
  private static final Map<String, Descriptor> DESCRIPTORS = new ConcurrentHashMap<>();

  final Handle handle;
  private final String typeName;
  private final Encoding encoding;
  private final long fingerprint;

  private Schema(long created) {
    handle = new Handle("schema", created, pointer -> {
      HgrosC.hgros_schema_free(pointer);
      return 0;
    }).closeWith(this);
    typeName = HgrosC.textAt(HgrosC.hgros_schema_type_name(created));
    encoding = Encoding.of(HgrosC.hgros_schema_encoding(created));
    fingerprint = HgrosC.hgros_schema_fingerprint(created);
  }

  private static Schema create(String typeName, int encoding, long fingerprint, byte[] set) {
    Texts.checked("The name of a type", typeName);
    long[] created = new long[1];
    HgrosC.check(HgrosC.hgros_schema_create(typeName, encoding, fingerprint, set, set == null ? 0 : set.length,
        created));
    return new Schema(created[0]);
  }

  /**
   * Names a type of your own whose bytes this package does not know. The fingerprint may be 0: then types are compared
   * by name and encoding alone.
   */
  public static Schema raw(String typeName, Encoding encoding, long fingerprint) {
    return create(typeName, encoding.ordinal(), fingerprint, null);
  }

  /** A type that comes with the library, such as "foxglove.Log". */
  public static Schema known(String typeName) {
    Texts.checked("The name of a type", typeName);
    long[] found = new long[1];
    HgrosC.check(HgrosC.hgros_schema_known(typeName, found));
    return new Schema(found[0]);
  }

  /** The type of protobuf messages with this descriptor: its name, and its file with all imports. */
  public static Schema of(Descriptor descriptor) {
    Schema known = OF_DESCRIPTORS.get(descriptor);
    if (known == null) {
      Map<String, FileDescriptorProto> files = new LinkedHashMap<>();
      addFile(files, descriptor.getFile());
      byte[] set = FileDescriptorSet.newBuilder().addAllFile(files.values()).build().toByteArray();
      known = create(descriptor.getFullName(), Encoding.PROTOBUF.ordinal(), 0, set);
      OF_DESCRIPTORS.put(descriptor, known);
    }
    return known;
  }

  /** Adds a file after its imports. */
  private static void addFile(Map<String, FileDescriptorProto> files, FileDescriptor file) {
    if (!files.containsKey(file.getFullName())) {
      file.getDependencies().forEach(dependency -> addFile(files, dependency));
      files.put(file.getFullName(), file.toProto());
    }
  }

  /** A copy of the one that belongs to a message. */
  static Schema copyOf(long schema) {
    return create(HgrosC.textAt(HgrosC.hgros_schema_type_name(schema)), HgrosC.hgros_schema_encoding(schema),
        HgrosC.hgros_schema_fingerprint(schema), descriptorSet(schema));
  }

  private static byte[] descriptorSet(long schema) {
    long[] size = new long[1];
    long set = HgrosC.hgros_schema_descriptor_set(schema, size);
    if (set == 0) {
      return null;
    }
    byte[] bytes = new byte[(int) size[0]];
    HgrosC.memoryAt(set, size[0]).get(bytes);
    return bytes;
  }

  /** The full name of the type. */
  public String typeName() {
    return typeName;
  }

  /** How its bytes are written. */
  public Encoding encoding() {
    return encoding;
  }

  /** Equal for equal types; 0: unknown. */
  public long fingerprint() {
    return fingerprint;
  }

  /** The type's protobuf description, as it came with the schema. */
  public Descriptor descriptor() {
    long schema = handle.enter();
    try {
      return descriptorOf(schema);
    } finally {
      handle.leave();
    }
  }

  /** The description of a schema of the library. It is built once for all messages of a type. */
  static Descriptor descriptorOf(long schema) {
    String typeName = HgrosC.textAt(HgrosC.hgros_schema_type_name(schema));
    long fingerprint = HgrosC.hgros_schema_fingerprint(schema);
    String key = typeName + " " + fingerprint;
    Descriptor descriptor = DESCRIPTORS.get(key);
    if (descriptor == null) {
      descriptor = build(typeName, descriptorSet(schema));
      if (fingerprint != 0) {
        DESCRIPTORS.put(key, descriptor);
      }
    }
    return descriptor;
  }

  private static Descriptor build(String typeName, byte[] set) {
    if (set == null) {
      throw new HgrosException(Code.NOT_FOUND, "The type \"" + typeName + "\" has no protobuf description.");
    }
    try {
      Map<String, FileDescriptor> files = new LinkedHashMap<>();
      for (FileDescriptorProto file : FileDescriptorSet.parseFrom(set).getFileList()) {
        FileDescriptor[] imports = file.getDependencyList().stream().map(files::get).toArray(FileDescriptor[]::new);
        files.put(file.getName(), FileDescriptor.buildFrom(file, imports));
      }
      for (FileDescriptor file : files.values()) {
        Descriptor found = find(file, typeName);
        if (found != null) {
          return found;
        }
      }
    } catch (InvalidProtocolBufferException | DescriptorValidationException e) {
      throw new HgrosException(Code.NOT_WRITABLE, "The description of " + typeName + ": " + e.getMessage());
    }
    throw new HgrosException(Code.NOT_FOUND, "The description of " + typeName + " has no message of this name.");
  }

  private static Descriptor find(FileDescriptor file, String typeName) {
    String before = file.getPackage().isEmpty() ? "" : file.getPackage() + ".";
    if (!typeName.startsWith(before)) {
      return null;
    }
    String[] names = typeName.substring(before.length()).split("\\.");
    Descriptor found = file.findMessageTypeByName(names[0]);
    for (int i = 1; i < names.length && found != null; i++) {
      found = found.findNestedTypeByName(names[i]);
    }
    return found;
  }
}
