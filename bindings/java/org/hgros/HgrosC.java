package org.hgros;

import com.sun.jna.Library;
import com.sun.jna.Native;
import com.sun.jna.NativeLibrary;
import com.sun.jna.Pointer;
import java.io.IOException;
import java.io.InputStream;
import java.net.URI;
import java.net.URISyntaxException;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.Map;

/**
 * The functions of the C interface (hgros/hgros.h), by JNA's direct mapping. Pointers and sizes are longs; an array of
 * one long is where a function writes its result.
 */
final class HgrosC {
  static {
    if (Native.POINTER_SIZE != Long.BYTES) {
      throw new UnsatisfiedLinkError("The binding for Java needs a system of 64 bits.");
    }
    addInstalledFolder();
    Native.register(HgrosC.class,
        NativeLibrary.getInstance("hgros_c", Map.of(Library.OPTION_STRING_ENCODING, "UTF-8")));
  }

  private HgrosC() {}

  /** An installed jar knows where its library is, relative to itself. Otherwise -Djna.library.path says it. */
  private static void addInstalledFolder() {
    try (InputStream resource = HgrosC.class.getResourceAsStream("library-folder")) {
      if (resource == null) {
        return;
      }
      String folder = new String(resource.readAllBytes(), StandardCharsets.UTF_8).strip();
      URI jar = HgrosC.class.getProtectionDomain().getCodeSource().getLocation().toURI();
      NativeLibrary.addSearchPath("hgros_c", Path.of(jar).resolveSibling(folder).normalize().toString());
    } catch (IOException | URISyntaxException | IllegalArgumentException e) {
      throw new ExceptionInInitializerError(e);
    }
  }

  static void check(int status) {
    if (status != 0) {
      throw new HgrosException(Code.of(status), textAt(hgros_last_error()));
    }
  }

  /** The text at an address; empty for NULL. */
  static String textAt(long address) {
    return address == 0 ? "" : new Pointer(address).getString(0, "UTF-8");
  }

  /** The memory at an address, which the buffer does not own. Empty for NULL. */
  static ByteBuffer memoryAt(long address, long size) {
    return address == 0 ? ByteBuffer.allocate(0) : new Pointer(address).getByteBuffer(0, size);
  }

  // hgros/c/status.h
  static native long hgros_status_name(int status);
  static native long hgros_last_error();
  static native void hgros_text_free(long text);

  // hgros/c/session.h
  static native int hgros_session_open(String yaml, Structs.SessionOptions options, long[] session);
  static native int hgros_session_open_files(Pointer files, long count, Structs.SessionOptions options, long[] session);
  static native void hgros_session_end(long session);
  static native void hgros_session_close(long session);
  static native long hgros_session_name(long session);
  static native long hgros_session_id(long session);
  static native int hgros_session_log(long session, int level, String text);
  static native int hgros_session_log_limited(long session, int level, String alike, String text);
  static native int hgros_session_wait_for_subscribers(long session, String channel, long count, long timeout_ns);
  static native int hgros_session_wait_for_publishers(long session, String channel, long count, long timeout_ns);

  // hgros/c/message.h
  static native int hgros_schema_create(String type_name, int encoding, long fingerprint, byte[] descriptor_set,
      long descriptor_set_size, long[] schema);
  static native int hgros_schema_known(String type_name, long[] schema);
  static native void hgros_schema_free(long schema);
  static native long hgros_schema_type_name(long schema);
  static native int hgros_schema_encoding(long schema);
  static native long hgros_schema_fingerprint(long schema);
  static native long hgros_schema_descriptor_set(long schema, long[] size);
  static native long hgros_message_data(long message, long[] size);
  static native long hgros_message_schema(long message);
  static native int hgros_message_get_info(long message, Structs.MessageInfo info);
  static native int hgros_message_keep(long message, long[] kept);
  static native void hgros_message_free(long message);
  static native long hgros_message_leases();

  // hgros/c/publish.h
  static native int hgros_publisher_open(long session, String channel, long schema, Structs.PublishOptions options,
      long[] publisher);
  static native void hgros_publisher_close(long publisher);
  static native int hgros_publish(long publisher, byte[] data, long size);
  static native int hgros_publish_wait(long publisher, byte[] data, long size, long timeout_ns);
  static native int hgros_loan_open(long publisher, long size, long[] loan);
  static native long hgros_loan_data(long loan, long[] size);
  static native int hgros_loan_publish(long loan, long timeout_ns);
  static native void hgros_loan_free(long loan);

  // hgros/c/subscribe.h
  static native int hgros_subscribe_queue(long session, String channel, Structs.SubscribeOptions options,
      long[] subscription);
  static native int hgros_queue_take(long queue, long timeout_ns, long[] message);
  static native int hgros_queue_descriptor(long queue);
  static native int hgros_subscription_get_stats(long subscription, Structs.SubscriptionStats stats);
  static native void hgros_subscription_close(long subscription);

  // hgros/c/services.h
  static native int hgros_serve(long session, String name, long request, long reply, Structs.ServeOptions options,
      long handler, long user, long release, long[] service);
  static native int hgros_reply_set(long reply, byte[] data, long size);
  static native int hgros_reply_fail(long reply, String sentence);
  static native void hgros_service_close(long service);
  static native int hgros_call(long session, String name, long request_schema, byte[] data, long size,
      long reply_schema, long timeout_ns, long[] reply);
  static native int hgros_call_later(long session, String name, long request_schema, byte[] data, long size,
      long reply_schema, long timeout_ns, long callback, long user, long release, long[] call);
  static native void hgros_call_cancel(long call);
  static native void hgros_call_free(long call);

  // hgros/c/params.h
  static native int hgros_params_open(long session, Pointer files, long count, long[] params);
  static native int hgros_params_of(long session, String name, long timeout_ns, long[] params);
  static native int hgros_params_close(long params);
  static native int hgros_params_declare(long params, String path, int kind, String fallback, Structs.ParamInfo info);
  static native int hgros_params_get_bool(long params, String path, int[] value);
  static native int hgros_params_get_integer(long params, String path, long[] value);
  static native int hgros_params_get_number(long params, String path, double[] value);
  static native int hgros_params_get_text(long params, String path, long[] value);
  static native int hgros_params_get(long params, String path, long[] yaml);
  static native int hgros_params_set_bool(long params, String path, int value);
  static native int hgros_params_set_integer(long params, String path, long value);
  static native int hgros_params_set_number(long params, String path, double value);
  static native int hgros_params_set_text(long params, String path, String value);
  static native int hgros_params_set(long params, String path, String yaml);
  static native int hgros_params_remove(long params, String path);
  static native int hgros_params_save(long params);
  static native int hgros_params_watch(long params, String path, long callback, long user, long release, long[] watch);

  // hgros/c/transforms.h
  static native int hgros_transforms_open(long session, long[] transforms);
  static native int hgros_transforms_close(long transforms);
  static native int hgros_transforms_set(long transforms, String parent, String child, Structs.Transform pose);
  static native int hgros_transforms_set_static(long transforms, String parent, String child, Structs.Transform pose);
  static native int hgros_transforms_lookup(long transforms, String target, String source, Structs.Transform found);
  static native int hgros_transforms_lookup_at(long transforms, String target, String source, long time_ns,
      Structs.Transform found);
  static native int hgros_transforms_wait(long transforms, String target, String source, long time_ns, long timeout_ns,
      Structs.Transform found);

  // hgros/c/observe.h
  static native int hgros_peers_open(long session, long[] peers);
  static native long hgros_peers_count(long peers);
  static native int hgros_peers_get(long peers, long index, Structs.Peer peer);
  static native void hgros_peers_free(long peers);
  static native int hgros_channels_open(long session, long[] channels);
  static native long hgros_channels_count(long channels);
  static native int hgros_channels_get(long channels, long index, Structs.Channel channel);
  static native void hgros_channels_free(long channels);
  static native void hgros_watch_close(long watch);
  static native int hgros_watch_peers(long session, long callback, long user, long release, long[] watch);
}
