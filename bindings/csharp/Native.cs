using System;
using System.Runtime.InteropServices;

namespace Hgros {
  // The C interface (hgros/hgros.h), as the binding uses it. Texts are UTF-8, as everywhere on Linux.
  internal static class Native {
    private const string Library = "libhgros_c.so.0";

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    internal delegate void Release(IntPtr user);
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    internal delegate void LogCallback(IntPtr user, int level, IntPtr text);
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    internal delegate void MessageCallback(IntPtr user, IntPtr message);
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    internal delegate void ServiceHandler(IntPtr user, IntPtr request, IntPtr reply);
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    internal delegate void ReplyCallback(IntPtr user, int status, IntPtr sentence, IntPtr reply);
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    internal delegate void ParamCallback(IntPtr user, IntPtr path, IntPtr yaml);
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    internal delegate void PeerCallback(IntPtr user, int happened, IntPtr peer, IntPtr channel, IntPtr reason);

    [StructLayout(LayoutKind.Sequential)]
    internal struct SessionOptions {
      internal UIntPtr Size;
      internal string Name;
      internal LogCallback Log;
      internal IntPtr LogUser;
      internal Release LogRelease;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct PublishOptions {
      internal UIntPtr Size;
      internal ulong Latched;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct SubscribeOptions {
      internal UIntPtr Size;
      internal string Name;
      internal IntPtr Schema;
      internal ulong KeepLast, KeepAll, KeepAllBytes;
      internal int Concurrent, Executor;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct SubscriptionStats {
      internal UIntPtr Size;
      internal ulong Received, Dropped, Run, Queued, Mismatched;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct MessageInfo {
      internal UIntPtr Size;
      internal int Remote;
      internal ulong Publisher, Incarnation, Sequence, Key;
      internal long PublishMonotonic, PublishTime;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct ServeOptions {
      internal UIntPtr Size;
      internal string Name;
      internal ulong MostWaiting;
      internal int Concurrent, Executor;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct ParamInfo {
      internal UIntPtr Size;
      internal int ReadOnly;
      internal string Description, Unit;
      internal int HasLeast, HasMost;
      internal double Least, Most;
      internal IntPtr Choices;
      internal UIntPtr ChoiceCount;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct Peer {
      internal UIntPtr Size;
      internal ulong Id;
      internal IntPtr Process, Host;
      internal long Pid;
      internal IntPtr Transport, Why;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct Channel {
      internal UIntPtr Size;
      internal IntPtr Name, TypeName;
      internal ulong Fingerprint;
      internal int Encoding;
      internal UIntPtr Publishers, Subscribers;
    }

    // What the structs of the library begin with.
    internal static UIntPtr SizeOf<T>() => (UIntPtr)(uint)Marshal.SizeOf(typeof(T));

    [DllImport(Library)] internal static extern IntPtr hgros_status_name(int status);
    [DllImport(Library)] internal static extern IntPtr hgros_last_error();
    [DllImport(Library)] internal static extern void hgros_text_free(IntPtr text);

    [DllImport(Library)]
    internal static extern int hgros_session_open(string yaml, [In] ref SessionOptions options,
      out SessionHandle session);
    [DllImport(Library)]
    internal static extern int hgros_session_open_files(string[] files, UIntPtr count,
      [In] ref SessionOptions options, out SessionHandle session);
    [DllImport(Library)] internal static extern void hgros_session_end(SessionHandle session);
    [DllImport(Library)] internal static extern void hgros_session_close(IntPtr session);
    [DllImport(Library)] internal static extern IntPtr hgros_session_name(SessionHandle session);
    [DllImport(Library)] internal static extern ulong hgros_session_id(SessionHandle session);
    [DllImport(Library)]
    internal static extern int hgros_session_log(SessionHandle session, int level, string text);
    [DllImport(Library)]
    internal static extern int hgros_session_log_limited(SessionHandle session, int level, string alike, string text);
    [DllImport(Library)]
    internal static extern int hgros_session_set_log_level(SessionHandle session, int level);
    [DllImport(Library)]
    internal static extern int hgros_session_wait_for_subscribers(SessionHandle session, string channel,
      UIntPtr count, long timeout);
    [DllImport(Library)]
    internal static extern int hgros_session_wait_for_publishers(SessionHandle session, string channel,
      UIntPtr count, long timeout);

    [DllImport(Library)]
    internal static extern int hgros_schema_create(string typeName, int encoding, ulong fingerprint,
      byte[] descriptorSet, UIntPtr size, out SchemaHandle schema);
    [DllImport(Library)]
    internal static extern int hgros_schema_known(string typeName, out SchemaHandle schema);
    [DllImport(Library)] internal static extern void hgros_schema_free(IntPtr schema);
    [DllImport(Library)] internal static extern IntPtr hgros_schema_type_name(IntPtr schema);
    [DllImport(Library)] internal static extern int hgros_schema_encoding(IntPtr schema);
    [DllImport(Library)] internal static extern ulong hgros_schema_fingerprint(IntPtr schema);
    [DllImport(Library)]
    internal static extern IntPtr hgros_schema_descriptor_set(IntPtr schema, out UIntPtr size);

    [DllImport(Library)] internal static extern IntPtr hgros_message_data(IntPtr message, out UIntPtr size);
    [DllImport(Library)] internal static extern IntPtr hgros_message_schema(IntPtr message);
    [DllImport(Library)]
    internal static extern int hgros_message_get_info(IntPtr message, ref MessageInfo info);
    [DllImport(Library)] internal static extern int hgros_message_keep(IntPtr message, out IntPtr kept);
    [DllImport(Library)] internal static extern void hgros_message_free(IntPtr message);
    [DllImport(Library)] internal static extern ulong hgros_message_leases();

    [DllImport(Library)]
    internal static extern int hgros_publisher_open(SessionHandle session, string channel, SchemaHandle schema,
      [In] ref PublishOptions options, out PublisherHandle publisher);
    [DllImport(Library)] internal static extern void hgros_publisher_close(IntPtr publisher);
    [DllImport(Library)]
    internal static extern int hgros_publish(PublisherHandle publisher, byte[] data, UIntPtr size);
    [DllImport(Library)]
    internal static extern int hgros_publish_wait(PublisherHandle publisher, byte[] data, UIntPtr size,
      long timeout);
    [DllImport(Library)]
    internal static extern int hgros_loan_open(PublisherHandle publisher, UIntPtr size, out IntPtr loan);
    [DllImport(Library)] internal static extern IntPtr hgros_loan_data(IntPtr loan, out UIntPtr size);
    [DllImport(Library)] internal static extern int hgros_loan_publish(IntPtr loan, long timeout);
    [DllImport(Library)] internal static extern void hgros_loan_free(IntPtr loan);

    [DllImport(Library)]
    internal static extern int hgros_subscribe(SessionHandle session, string channel,
      [In] ref SubscribeOptions options, MessageCallback callback, IntPtr user, Release release,
      out SubscriptionHandle subscription);
    [DllImport(Library)]
    internal static extern int hgros_subscribe_queue(SessionHandle session, string channel,
      [In] ref SubscribeOptions options, out SubscriptionHandle subscription);
    [DllImport(Library)]
    internal static extern int hgros_queue_take(SubscriptionHandle queue, long timeout, out IntPtr message);
    [DllImport(Library)] internal static extern int hgros_queue_descriptor(SubscriptionHandle queue);
    [DllImport(Library)]
    internal static extern int hgros_subscription_get_stats(SubscriptionHandle subscription,
      ref SubscriptionStats stats);
    [DllImport(Library)] internal static extern void hgros_subscription_end(SubscriptionHandle subscription);
    [DllImport(Library)] internal static extern void hgros_subscription_close(IntPtr subscription);

    [DllImport(Library)]
    internal static extern int hgros_serve(SessionHandle session, string name, SchemaHandle request,
      SchemaHandle reply, [In] ref ServeOptions options, ServiceHandler handler, IntPtr user, Release release,
      out ServiceHandle service);
    [DllImport(Library)] internal static extern void hgros_service_close(IntPtr service);
    [DllImport(Library)]
    internal static extern int hgros_reply_set(IntPtr reply, byte[] data, UIntPtr size);
    [DllImport(Library)] internal static extern int hgros_reply_fail(IntPtr reply, string sentence);
    [DllImport(Library)]
    internal static extern int hgros_call(SessionHandle session, string name, SchemaHandle requestSchema,
      byte[] data, UIntPtr size, SchemaHandle replySchema, long timeout, out IntPtr reply);
    [DllImport(Library)]
    internal static extern int hgros_call_later(SessionHandle session, string name, SchemaHandle requestSchema,
      byte[] data, UIntPtr size, SchemaHandle replySchema, long timeout, ReplyCallback callback, IntPtr user,
      Release release, out PendingCallHandle call);
    [DllImport(Library)] internal static extern void hgros_call_cancel(PendingCallHandle call);
    [DllImport(Library)] internal static extern void hgros_call_free(IntPtr call);

    [DllImport(Library)]
    internal static extern int hgros_params_open(SessionHandle session, string[] files, UIntPtr count,
      out ParamsHandle parameters);
    [DllImport(Library)]
    internal static extern int hgros_params_of(SessionHandle session, string name, long timeout,
      out ParamsHandle parameters);
    [DllImport(Library)] internal static extern int hgros_params_close(IntPtr parameters);
    [DllImport(Library)]
    internal static extern int hgros_params_declare(ParamsHandle parameters, string path, int kind,
      string fallback, [In] ref ParamInfo info);
    [DllImport(Library)]
    internal static extern int hgros_params_get_bool(ParamsHandle parameters, string path, out int value);
    [DllImport(Library)]
    internal static extern int hgros_params_get_integer(ParamsHandle parameters, string path, out long value);
    [DllImport(Library)]
    internal static extern int hgros_params_get_number(ParamsHandle parameters, string path, out double value);
    [DllImport(Library)]
    internal static extern int hgros_params_get_text(ParamsHandle parameters, string path, out IntPtr value);
    [DllImport(Library)]
    internal static extern int hgros_params_get(ParamsHandle parameters, string path, out IntPtr yaml);
    [DllImport(Library)]
    internal static extern int hgros_params_set_bool(ParamsHandle parameters, string path, int value);
    [DllImport(Library)]
    internal static extern int hgros_params_set_integer(ParamsHandle parameters, string path, long value);
    [DllImport(Library)]
    internal static extern int hgros_params_set_number(ParamsHandle parameters, string path, double value);
    [DllImport(Library)]
    internal static extern int hgros_params_set_text(ParamsHandle parameters, string path, string value);
    [DllImport(Library)]
    internal static extern int hgros_params_set(ParamsHandle parameters, string path, string yaml);
    [DllImport(Library)] internal static extern int hgros_params_remove(ParamsHandle parameters, string path);
    [DllImport(Library)] internal static extern int hgros_params_save(ParamsHandle parameters);
    [DllImport(Library)]
    internal static extern int hgros_params_watch(ParamsHandle parameters, string path, ParamCallback callback,
      IntPtr user, Release release, out WatchHandle watch);

    [DllImport(Library)]
    internal static extern int hgros_transforms_open(SessionHandle session, out TransformsHandle transforms);
    [DllImport(Library)] internal static extern int hgros_transforms_close(IntPtr transforms);
    [DllImport(Library)]
    internal static extern int hgros_transforms_set(TransformsHandle transforms, string parent, string child,
      [In] ref Transform pose);
    [DllImport(Library)]
    internal static extern int hgros_transforms_set_static(TransformsHandle transforms, string parent,
      string child, [In] ref Transform pose);
    [DllImport(Library)]
    internal static extern int hgros_transforms_lookup(TransformsHandle transforms, string target,
      string source, out Transform found);
    [DllImport(Library)]
    internal static extern int hgros_transforms_lookup_at(TransformsHandle transforms, string target,
      string source, long time, out Transform found);
    [DllImport(Library)]
    internal static extern int hgros_transforms_wait(TransformsHandle transforms, string target, string source,
      long time, long timeout, out Transform found);

    [DllImport(Library)] internal static extern int hgros_peers_open(SessionHandle session, out IntPtr peers);
    [DllImport(Library)] internal static extern UIntPtr hgros_peers_count(IntPtr peers);
    [DllImport(Library)] internal static extern int hgros_peers_get(IntPtr peers, UIntPtr index, ref Peer peer);
    [DllImport(Library)] internal static extern void hgros_peers_free(IntPtr peers);
    [DllImport(Library)]
    internal static extern int hgros_channels_open(SessionHandle session, out IntPtr channels);
    [DllImport(Library)] internal static extern UIntPtr hgros_channels_count(IntPtr channels);
    [DllImport(Library)]
    internal static extern int hgros_channels_get(IntPtr channels, UIntPtr index, ref Channel channel);
    [DllImport(Library)] internal static extern void hgros_channels_free(IntPtr channels);
    [DllImport(Library)]
    internal static extern int hgros_watch_peers(SessionHandle session, PeerCallback callback, IntPtr user,
      Release release, out WatchHandle watch);
    [DllImport(Library)] internal static extern void hgros_watch_close(IntPtr watch);
  }
}
