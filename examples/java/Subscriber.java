import com.google.protobuf.TextFormat;
import org.hgros.HgrosException;
import org.hgros.ReceivedMessage;
import org.hgros.Session;
import org.hgros.SubscribeOptions;

/** Shows messages of any type with the description that comes with the channel: Subscriber CHANNEL [COUNT]. */
public class Subscriber {
  public static void main(String[] arguments) throws InterruptedException {
    long count = arguments.length > 1 ? Long.parseLong(arguments[1]) : Long.MAX_VALUE;
    try (Session session = Session.open()) {
      var queue = session.subscribeRaw(arguments[0], new SubscribeOptions().keepAll(100));
      for (; count > 0; count--) {
        try (ReceivedMessage message = queue.take()) {
          show(message);
        }
      }
    }
  }

  private static void show(ReceivedMessage message) {
    try {
      var decoded = message.decode();
      String text = TextFormat.printer().escapingNonAscii(false).shortDebugString(decoded);
      System.out.println(decoded.getDescriptorForType().getFullName() + ": " + text);
    } catch (HgrosException e) {
      System.out.println(e);
    }
  }
}
