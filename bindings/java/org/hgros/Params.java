package org.hgros;

import java.util.Arrays;
import java.util.function.BiConsumer;
import java.util.function.LongToIntFunction;

/** A tree of parameters. A path is written like slam.matcher.gains[2]. */
public final class Params implements AutoCloseable {
  private static final int BOOL = 0;
  private static final int INTEGER = 1;
  private static final int NUMBER = 2;
  private static final int TEXT = 3;
  private static final int NUMBERS = 4;
  private static final String VALUE = "The value of a parameter";

  private final Session session;
  private final Handle handle;

  @FunctionalInterface
  interface Opening {
    int open(long session, long[] params);
  }

  Params(Session session, Opening opening) {
    this.session = session;
    long[] opened = new long[1];
    session.handle.call(owner -> opening.open(owner, opened));
    handle = new Handle("object for parameters", opened[0], HgrosC::hgros_params_close).closeWith(this);
  }

  /** Ends the parameters. Throws {@link Code#WOULD_DEADLOCK} inside a callback of the session: then they stay open. */
  @Override
  public void close() {
    handle.close();
  }

  /** Gives a parameter its kind, bounds, and the value that it has if it was never set. */
  public void declare(String path, boolean fallback, ParamInfo info) {
    declare(path, BOOL, Boolean.toString(fallback), info);
  }

  public void declare(String path, long fallback, ParamInfo info) {
    declare(path, INTEGER, Long.toString(fallback), info);
  }

  public void declare(String path, double fallback, ParamInfo info) {
    declare(path, NUMBER, yaml(fallback), info);
  }

  public void declare(String path, String fallback, ParamInfo info) {
    declare(path, TEXT, yaml(Texts.checked(VALUE, fallback)), info);
  }

  public void declare(String path, double[] fallback, ParamInfo info) {
    declare(path, NUMBERS, yaml(fallback), info);
  }

  private void declare(String path, int kind, String fallback, ParamInfo info) {
    Structs.ParamInfo chosen = new Structs.ParamInfo();
    chosen.read_only = info.readOnly ? 1 : 0;
    chosen.description = Texts.checked("The description of a parameter", info.description);
    chosen.unit = Texts.checked("The unit of a parameter", info.unit);
    if (info.least != null) {
      chosen.has_least = 1;
      chosen.least = info.least;
    }
    if (info.most != null) {
      chosen.has_most = 1;
      chosen.most = info.most;
    }
    if (info.choices.length > 0) {
      chosen.choices = Texts.list("A choice of a parameter", info.choices);
      chosen.choice_count = info.choices.length;
    }
    at(path, params -> HgrosC.hgros_params_declare(params, path, kind, fallback, chosen));
  }

  /** Calls the library for a path. */
  private void at(String path, LongToIntFunction call) {
    Texts.checked("The path of a parameter", path);
    handle.call(call);
  }

  private static String yaml(double number) {
    if (Double.isNaN(number)) {
      return ".nan";
    }
    if (Double.isInfinite(number)) {
      return number > 0 ? ".inf" : "-.inf";
    }
    return Double.toString(number);
  }

  private static String yaml(double[] numbers) {
    return Arrays.stream(numbers).mapToObj(Params::yaml).toList().toString();
  }

  private static String yaml(String text) {
    StringBuilder quoted = new StringBuilder("\"");
    for (char c : text.toCharArray()) {
      if (c < ' ') {
        quoted.append(String.format("\\x%02x", (int) c));
      } else {
        quoted.append(c == '"' || c == '\\' ? "\\" : "").append(c);
      }
    }
    return quoted.append('"').toString();
  }

  public boolean getBool(String path) {
    int[] value = new int[1];
    at(path, params -> HgrosC.hgros_params_get_bool(params, path, value));
    return value[0] != 0;
  }

  public long getInteger(String path) {
    long[] value = new long[1];
    at(path, params -> HgrosC.hgros_params_get_integer(params, path, value));
    return value[0];
  }

  public double getNumber(String path) {
    double[] value = new double[1];
    at(path, params -> HgrosC.hgros_params_get_number(params, path, value));
    return value[0];
  }

  public String getText(String path) {
    long[] text = new long[1];
    return text(path, text, params -> HgrosC.hgros_params_get_text(params, path, text));
  }

  /** Any value, as YAML. An empty path is the whole tree. */
  public String getYaml(String path) {
    long[] text = new long[1];
    return text(path, text, params -> HgrosC.hgros_params_get(params, path, text));
  }

  private String text(String path, long[] text, LongToIntFunction get) {
    at(path, get);
    try {
      return HgrosC.textAt(text[0]);
    } finally {
      HgrosC.hgros_text_free(text[0]);
    }
  }

  /** Sets a value. Throws {@link Code#REFUSED} if it breaks a declaration. */
  public void set(String path, boolean value) {
    at(path, params -> HgrosC.hgros_params_set_bool(params, path, value ? 1 : 0));
  }

  public void set(String path, long value) {
    at(path, params -> HgrosC.hgros_params_set_integer(params, path, value));
  }

  public void set(String path, double value) {
    at(path, params -> HgrosC.hgros_params_set_number(params, path, value));
  }

  public void set(String path, String value) {
    Texts.checked(VALUE, value);
    at(path, params -> HgrosC.hgros_params_set_text(params, path, value));
  }

  public void set(String path, double[] value) {
    setYaml(path, yaml(value));
  }

  /** Sets a value as YAML, such as "{x: 1}". */
  public void setYaml(String path, String yaml) {
    Texts.checked(VALUE, yaml);
    at(path, params -> HgrosC.hgros_params_set(params, path, yaml));
  }

  /** Removes a value; a declared parameter returns to its fallback. */
  public void remove(String path) {
    at(path, params -> HgrosC.hgros_params_remove(params, path));
  }

  /** Writes what was set at run time into the files of this program. */
  public void save() {
    handle.call(HgrosC::hgros_params_save);
  }

  /**
   * Calls `listener` with the path and the YAML of each changed value at, below or above a path, or with null if it was
   * removed. It runs on the thread that makes the change; for another session on a worker, first with all current
   * values.
   */
  public Watch onChange(String path, BiConsumer<String, String> listener) {
    Texts.checked("The path of a parameter", path);
    return Watch.open(session, this, "The listener for changes of \"" + path + "\"",
        runner -> (Callbacks.ChangeTarget) (changed, yaml) -> runner.run(() -> listener.accept(changed, yaml)),
        (user, watch) -> handle.status(
            params -> HgrosC.hgros_params_watch(params, path, Callbacks.CHANGE, user, Callbacks.RELEASE, watch)));
  }
}
