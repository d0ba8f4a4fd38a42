package org.hgros;

import com.sun.jna.Pointer;
import com.sun.jna.Structure;

/** The structs of the C interface, field by field. JNA reads them by reflection, so classes and fields are public. */
final class Structs {
  private Structs() {}

  /** A struct that begins with its size. */
  public abstract static class Sized extends Structure {
    public long size;

    Sized() {
      setStringEncoding("UTF-8");
      size = size();
    }

    Sized(Pointer address) {
      super(address);
      setStringEncoding("UTF-8");
      read();
    }
  }

  @Structure.FieldOrder({"size", "name", "log", "log_user", "log_release"})
  public static final class SessionOptions extends Sized {
    public String name;
    public long log;
    public long log_user;
    public long log_release;
  }

  @Structure.FieldOrder({"size", "latched"})
  public static final class PublishOptions extends Sized {
    public long latched;
  }

  @Structure.FieldOrder({"size", "name", "schema", "keep_last", "keep_all", "keep_all_bytes", "concurrent", "executor"})
  public static final class SubscribeOptions extends Sized {
    public String name;
    public long schema;
    public long keep_last;
    public long keep_all;
    public long keep_all_bytes;
    public int concurrent;
    public int executor;
  }

  @Structure.FieldOrder({"size", "received", "dropped", "run", "queued", "mismatched", "queue_wait_p50_ns",
      "queue_wait_p99_ns"})
  public static final class SubscriptionStats extends Sized {
    public long received;
    public long dropped;
    public long run;
    public long queued;
    public long mismatched;
    public long queue_wait_p50_ns;
    public long queue_wait_p99_ns;
  }

  @Structure.FieldOrder({"size", "remote", "publisher", "incarnation", "sequence", "key", "publish_monotonic_ns",
      "publish_time_ns"})
  public static final class MessageInfo extends Sized {
    public int remote;
    public long publisher;
    public long incarnation;
    public long sequence;
    public long key;
    public long publish_monotonic_ns;
    public long publish_time_ns;
  }

  @Structure.FieldOrder({"size", "name", "most_waiting", "concurrent", "executor"})
  public static final class ServeOptions extends Sized {
    public String name;
    public long most_waiting;
    public int concurrent;
    public int executor;
  }

  @Structure.FieldOrder({"size", "read_only", "description", "unit", "has_least", "has_most", "least", "most",
      "choices", "choice_count"})
  public static final class ParamInfo extends Sized {
    public int read_only;
    public String description;
    public String unit;
    public int has_least;
    public int has_most;
    public double least;
    public double most;
    public Pointer choices;
    public long choice_count;
  }

  @Structure.FieldOrder({"translation", "rotation", "stamp_ns"})
  public static final class Transform extends Structure {
    public double[] translation = new double[3];
    public double[] rotation = new double[4];
    public long stamp_ns;
  }

  @Structure.FieldOrder({"size", "id", "process", "host", "pid", "transport", "why"})
  public static final class Peer extends Sized {
    public long id;
    public String process;
    public String host;
    public long pid;
    public String transport;
    public String why;

    public Peer() {}

    public Peer(Pointer address) {
      super(address);
    }
  }

  @Structure.FieldOrder({"size", "name", "type_name", "fingerprint", "encoding", "publishers", "subscribers"})
  public static final class Channel extends Sized {
    public String name;
    public String type_name;
    public long fingerprint;
    public int encoding;
    public long publishers;
    public long subscribers;
  }
}
