import com.google.protobuf.StringValue;
import java.time.Duration;
import org.hgros.PublishOptions;
import org.hgros.Session;

/** Publishes five greetings, which nobody has to wait for: the channel keeps the newest ones for late subscribers. */
public class Publisher {
  public static void main(String[] arguments) throws InterruptedException {
    Duration minute = Duration.ofMinutes(1);
    try (Session session = Session.open()) {
      var publisher = session.advertise("greetings", StringValue.getDefaultInstance(), new PublishOptions().latched(5));
      for (int i = 1; i <= 5; i++) {
        publisher.publish(StringValue.of("Hello " + i), minute);
      }
      session.waitForSubscribers("greetings", 1, minute);
      System.out.println("published");
    }
  }
}
