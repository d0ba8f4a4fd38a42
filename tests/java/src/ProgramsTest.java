import java.io.BufferedReader;
import java.io.IOException;
import java.io.InputStreamReader;
import java.io.OutputStreamWriter;
import java.io.Writer;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.concurrent.BlockingQueue;
import java.util.concurrent.LinkedBlockingQueue;
import java.util.concurrent.TimeUnit;

/** The peer of tests/interop in two processes, and the peer with the `hgros` command, which is C++. */
final class ProgramsTest {
  private static final List<String> PEER = List.of(System.getProperty("hgros.peer").split("\\|"));
  private static final String COMMAND = System.getProperty("hgros.command");

  private ProgramsTest() {}

  /** A process whose lines are awaited. It is killed when the test ends. */
  private static final class Program implements AutoCloseable {
    private final Process process;
    private final BlockingQueue<String> lines = new LinkedBlockingQueue<>();
    private final Writer input;
    final Path log;

    Program(List<String> command, String... arguments) throws IOException {
      List<String> all = new ArrayList<>(command);
      all.addAll(Arrays.asList(arguments));
      log = Files.createTempFile("program", ".log");
      process = new ProcessBuilder(all).redirectError(log.toFile()).start();
      input = new OutputStreamWriter(process.getOutputStream());
      Thread reader = new Thread(() -> {
        try (BufferedReader output = new BufferedReader(new InputStreamReader(process.getInputStream()))) {
          output.lines().forEach(lines::add);
        } catch (IOException e) {
          lines.add(e.toString());
        }
      });
      reader.setDaemon(true);
      reader.start();
    }

    static Program peer(String... arguments) throws IOException {
      return new Program(PEER, arguments);
    }

    static Program command(String... arguments) throws IOException {
      return new Program(List.of(COMMAND), arguments);
    }

    void says(String line) throws Exception {
      String said = lines.poll(Expect.PATIENCE.toSeconds(), TimeUnit.SECONDS);
      Expect.holds(line.equals(said), said + " instead of " + line + "; " + Files.readString(log));
    }

    void eventuallySays(String part) throws Exception {
      for (String said = ""; !said.contains(part); ) {
        said = lines.poll(Expect.PATIENCE.toSeconds(), TimeUnit.SECONDS);
        Expect.holds(said != null, "nobody said " + part + "; " + Files.readString(log));
      }
    }

    /** Ends it as its user does. */
    void ends() throws Exception {
      input.close();
      Expect.holds(process.waitFor(Expect.PATIENCE.toSeconds(), TimeUnit.SECONDS), "it did not end");
      Expect.holds(process.exitValue() == 0, process.exitValue() + "; " + Files.readString(log));
    }

    void write(String line) throws IOException {
      input.write(line + "\n");
      input.flush();
    }

    void kill() {
      process.destroyForcibly().onExit().join();
    }

    @Override
    public void close() throws IOException {
      kill();
      Files.delete(log);
    }
  }

  public static void peersPublishAndSubscribe() throws Exception {
    try (Program to = Program.peer("subscribe", "words", "1000");
        Program from = Program.peer("publish", "words", "1000")) {
      to.says("subscribed");
      from.says("published 1000");
      to.says("received 1000");
      to.ends();
      from.ends();
    }
  }

  public static void peersLatchAndComeLate() throws Exception {
    try (Program from = Program.peer("latch", "map", "kept")) {
      from.says("latched");
      try (Program to = Program.peer("late", "map")) {
        to.says("late kept");
        to.ends();
      }
      from.ends();
    }
  }

  public static void peersSendBulkData() throws Exception {
    String size = Integer.toString(4 << 20);
    try (Program to = Program.peer("bulk-subscribe", "cloud", size);
        Program from = Program.peer("bulk-publish", "cloud", size)) {
      to.says("subscribed");
      from.says("published " + size);
      to.says("received " + size);
      from.ends();
    }
  }

  public static void peersServeAndCall() throws Exception {
    try (Program server = Program.peer("serve", "echo"); Program client = Program.peer("talk")) {
      server.says("serving");
      client.says("ready");
      client.write("call echo hello");
      client.says("answer re: hello");
      client.write("call echo fail");
      client.says("failed asked to fail");
      client.ends();
      server.ends();
    }
  }

  public static void peersNameTypesThatDiffer() throws Exception {
    try (Program from = Program.peer("latch", "words", "x"); Program to = Program.peer("misfit", "words")) {
      from.says("latched");
      to.says("subscribed");
      Expect.eventually("the log names both types", () -> {
        String log = Files.readString(to.log);
        return log.contains("foxglove.Log") && log.contains("foxglove.PoseInFrame");
      });
      to.ends();
      from.ends();
    }
  }

  public static void peersSurviveTheDeathOfTheOther() throws Exception {
    try (Program from = Program.peer("stream", "words"); Program survivor = Program.peer("follow", "words")) {
      from.says("streaming");
      survivor.says("following");
      try (Program victim = Program.peer("follow", "words")) {
        victim.says("following");
        victim.kill();
      }
      from.kill();
      try (Program again = Program.peer("stream", "words")) {
        again.says("streaming");
        again.ends();
      }
      survivor.ends();
    }
  }

  public static void theCommandHearsAndIsHeard() throws Exception {
    try (Program to = Program.command("echo", "words", "--count", "1");
        Program from = Program.peer("latch", "words", "hello")) {
      from.says("latched");
      to.eventuallySays("hello");
      from.ends();
    }
    try (Program to = Program.peer("late", "orders");
        Program from = Program.command("pub", "orders", "{message: go}", "--type", "foxglove.Log", "--latched")) {
      to.says("late go");
      to.ends();
    }
  }

  public static void theCommandCalls() throws Exception {
    try (Program server = Program.peer("serve", "echo")) {
      server.says("serving");
      try (Program client = Program.command("call", "echo", "{message: hello}", "--timeout", "40")) {
        client.eventuallySays("re: hello");
      }
      server.ends();
    }
  }
}
