import com.google.protobuf.StringValue;
import java.time.Duration;
import org.hgros.PublishOptions;
import org.hgros.Session;

/** Publishes five greetings as soon as somebody subscribes. */
public class Publisher {
  public static void main(String[] arguments) throws InterruptedException {
    Duration minute = Duration.ofMinutes(1);
    try (Session session = Session.open()) {
      var publisher = session.advertise("greetings", StringValue.getDefaultInstance(), new PublishOptions().latched(5));
      session.waitForSubscribers("greetings", 1, minute);
      for (int i = 1; i <= 5; i++) {
        publisher.publish(StringValue.of("Hello " + i), minute);
      }
      System.out.println("published");
    }
  }
}
