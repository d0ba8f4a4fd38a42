import com.google.protobuf.DoubleValue;
import java.time.Duration;
import org.hgros.Code;
import org.hgros.HgrosException;
import org.hgros.Session;

/** Serves the square root of a number, and calls it twice: once with a number that has none. */
public class RootService {
  private static final DoubleValue NUMBER = DoubleValue.getDefaultInstance();

  private static DoubleValue root(DoubleValue number) {
    if (number.getValue() < 0) {
      throw new IllegalArgumentException("there is no root of a number below zero");
    }
    return DoubleValue.of(Math.sqrt(number.getValue()));
  }

  public static void main(String[] arguments) {
    try (Session session = Session.open()) {
      session.serve("root", NUMBER, NUMBER, RootService::root);
      for (double number : new double[] {16, -1}) {
        try {
          DoubleValue reply = session.call("root", DoubleValue.of(number), NUMBER, Duration.ofMinutes(1));
          System.out.println("The root of " + number + " is " + reply.getValue());
        } catch (HgrosException e) {
          if (e.code() != Code.HANDLER_FAILED) {
            throw e;
          }
          System.out.println(e);
        }
      }
    }
  }
}
