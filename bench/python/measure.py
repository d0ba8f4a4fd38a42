"""measure.py CPP_SIDE [--quick]: prints metric,value,unit. See `run`."""

import os
import statistics
import subprocess
import sys
import time

IDLE = """
import hgros, resource, sys, time
with hgros.Session() as robot, hgros.Session() as other:
    for i in range(20):
        robot.subscribe(f"channel{i}", callback=lambda message, info: None)
    robot.start()
    time.sleep(2)  # Connected by then.
    def used():
        usage = resource.getrusage(resource.RUSAGE_SELF)
        return usage.ru_utime + usage.ru_stime
    begin, begin_used = time.monotonic(), used()
    time.sleep(float(sys.argv[1]))
    print(100 * (used() - begin_used) / (time.monotonic() - begin))
"""
IMPORT = "import time; begin = time.perf_counter(); import hgros; print(1e3 * (time.perf_counter() - begin))"


def report(metric, value, unit):
    print(f"{metric},{value:.4g},{unit}", flush=True)


def python(code, *arguments):
    return float(subprocess.run([sys.executable, "-B", "-c", code, *arguments], check=True, stdout=subprocess.PIPE).stdout)


def messages(cpp_side, rounds, flood):
    """Latencies beside C++, and messages per second."""
    import hgros

    small, large, written, sums = [], [], [], 0
    with hgros.Session() as robot:
        received = 0
        begin = end = 0.0

        @robot.subscribe("small_py")
        def on_small(scan, info):
            now = time.monotonic_ns()
            small.append(now - scan.timestamp.ToNanoseconds())

        @robot.subscribe("large_py")
        def on_large(cloud, info):
            nonlocal sums
            data = hgros.data(cloud)
            sums += data[0] + data[-1]
            now = time.monotonic_ns()
            large.append(now - cloud.timestamp.ToNanoseconds())
            written.append(now - int(cloud.frame_id))

        @robot.subscribe("flood", queue=hgros.KeepAll(1000))
        def on_flood(scan, info):
            nonlocal received, begin, end
            received += 1
            if received == 1:
                begin = time.perf_counter()
            elif received == flood:
                end = time.perf_counter()
                robot.stop()

        listener = subprocess.Popen([cpp_side, "listen", str(rounds)], stdout=subprocess.PIPE, text=True)
        talker = subprocess.Popen([cpp_side, "talk", str(rounds), str(flood)])
        robot.spin()
        out, _ = listener.communicate(timeout=30)
        if talker.wait(30) or listener.returncode or sums != 3 * rounds or len(small) != rounds:
            sys.exit("A message was lost.")
    cpp_small, cpp_large, cpp_written = (int(word) for word in out.split())
    report("py_latency_us_1KB", statistics.median(small) / 1e3, "us")
    report("cpp_latency_us_1KB", cpp_small / 1e3, "us")
    report("py_latency_over_cpp_us_1KB", (statistics.median(small) - cpp_small) / 1e3, "us")
    report("py_bulk_4MB_us", statistics.median(large) / 1e3, "us")
    report("cpp_bulk_4MB_us", cpp_large / 1e3, "us")
    report("py_bulk_4MB_published_over_cpp", statistics.median(large) / cpp_large, "ratio")
    report("py_bulk_4MB_over_cpp", statistics.median(written) / cpp_written, "ratio")
    report("py_msgs_s_1KB", flood / (end - begin), "1/s")


def publishing(rounds):
    """By loan, the bytes not counted that a program writes into it; and as an ordinary message."""
    import hgros
    from foxglove.PointCloud_pb2 import PointCloud

    size = 10_000_000
    with hgros.Session() as robot, hgros.Session() as other:
        clouds = other.messages("points", timeout=10, queue=hgros.KeepAll(2))
        publisher = robot.advertise("points", PointCloud)
        robot.wait_for_subscribers("points")
        by_loan, ordinary = [], []
        message = PointCloud(data=bytes(size))
        for _ in range(rounds):
            begin = time.perf_counter()
            with publisher.loan(size) as cloud:
                cloud.frame_id = "laser"
            by_loan.append(time.perf_counter() - begin)
            next(clouds)
            begin = time.perf_counter()
            publisher.publish(message)
            ordinary.append(time.perf_counter() - begin)
            next(clouds)
    report("py_publish_10MB_ms", statistics.median(by_loan) * 1e3, "ms")
    report("py_publish_10MB_ordinary_ms", statistics.median(ordinary) * 1e3, "ms")


def main():
    cpp_side, quick = os.path.abspath(sys.argv[1]), "--quick" in sys.argv
    report("py_import_ms", statistics.median(python(IMPORT) for _ in range(3 if quick else 11)), "ms")
    messages(cpp_side, 50 if quick else 500, 20_000 if quick else 200_000)
    publishing(20 if quick else 100)
    report("py_idle_cpu_percent", python(IDLE, "2" if quick else "10"), "%")


if __name__ == "__main__":
    main()
