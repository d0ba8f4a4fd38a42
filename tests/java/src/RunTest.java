import java.lang.reflect.InvocationTargetException;

/** Runs one test, a public static method: CLASS METHOD. */
final class RunTest {
  private RunTest() {}

  public static void main(String[] arguments) throws ReflectiveOperationException {
    try {
      Class.forName(arguments[0]).getMethod(arguments[1]).invoke(null);
    } catch (InvocationTargetException e) {
      e.getCause().printStackTrace();
      System.exit(1);
    }
    System.out.println("PASS " + arguments[1]);
    System.exit(0); // Also if a test has left a thread.
  }
}
