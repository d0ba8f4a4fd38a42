"""The results of all rounds: metrics as (name, value, unit), and the table of single runs."""

import csv
import statistics

from plan import size_name


def percentile(values, fraction):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(fraction * len(ordered)))]


def of_size(runs, size):
    """The runs whose latencies of single messages of that size count."""
    return [run for run in runs if run.lane.size == size and not run.lane.paced]


class Results:
    """Collects the rounds: `rounds[round][mode]` is a list of Found, one per lane."""

    def __init__(self, modes, plan):
        self.modes, self.plan, self.rounds, self.whole = modes, plan, [], 0

    def begin_round(self):
        self.rounds.append({})

    def end_round(self):
        self.whole += 1

    def add(self, mode, found):
        self.rounds[-1][mode] = found

    def of(self, mode, index):
        """The results of each round on one lane."""
        return [one[mode][index] for one in self.rounds if mode in one]

    def in_round(self, one, modes, size):
        """Median latency of the fastest of these modes in one round, in us. None if none of them carried that size."""
        found = (run.p50_us for mode in modes for run in of_size(one.get(mode, ()), size))
        return min((value for value in found if value), default=None)

    def ratio(self, ours, others, size, their_size=None):
        """Median over the rounds of our latency divided by the fastest of the others, both in the same round.
        None if no round has both."""
        values = []
        for one in self.rounds:
            mine, theirs = self.in_round(one, ours, size), self.in_round(one, others, their_size or size)
            if mine and theirs:
                values.append(mine / theirs)
        return statistics.median(values) if values else None

    def median(self, mode, size):
        """Median latency over all messages of all rounds, in us. None if there are none."""
        runs = [run for one in self.rounds for run in of_size(one.get(mode, ()), size)]
        values = [value for run in runs for value in run.latencies_us]
        return statistics.median(values) if values else None

    def metrics(self):
        yield "rounds", self.whole, "count"
        for mode in self.modes:
            yield from self.of_mode(mode)
        for ours in self.modes:
            if ours.peer != "ours":
                continue
            for other in self.modes:
                if other.peer != "ours" and (other.inter, other.receivers) == (ours.inter, ours.receivers):
                    yield from self.ratios(ours, other)

    def of_mode(self, mode):
        for index, lane in enumerate(self.plan.lanes(mode)):
            runs, size = self.of(mode, index), size_name(lane.size)
            latencies = [value for run in runs for value in run.latencies_us]
            lost = sum(run.lost for run in runs)
            if lane.paced:
                speeds = [run.paced_mb_per_s for run in runs if run.paced_mb_per_s]
                if speeds:
                    yield f"{mode.key}_paced_mb_per_s_{size}", statistics.median(speeds), "MB/s"
                continue
            if latencies:
                yield f"{mode.key}_p50_us_{size}", statistics.median(latencies), "us"
                yield f"{mode.key}_mean_us_{size}", statistics.fmean(latencies), "us"
                yield f"{mode.key}_p99_us_{size}", percentile(latencies, 0.99), "us"
            if lost:
                yield f"{mode.key}_lost_{size}", lost, "messages"
            runs = [run for run in runs if run.lane.flood_ms]
            if runs:
                yield f"{mode.key}_msgs_per_s_{size}", statistics.median(run.per_s for run in runs), "1/s"
                flood_lost = statistics.median(run.flood_lost_percent for run in runs)
                if flood_lost:
                    yield f"{mode.key}_flood_lost_{size}", flood_lost, "%"

    def ratios(self, ours, other):
        """Medians over the rounds of ours divided by the other's, both in the same round."""
        both = [(one[ours], one[other]) for one in self.rounds if ours in one and other in one]
        for index, lane in enumerate(self.plan.lanes(ours)):
            pairs = [(mine[index], theirs[index]) for mine, theirs in both]
            name, size = f"{ours.key}_vs_{other.key}", size_name(lane.size)
            if not lane.paced:
                values = [mine.p50_us / theirs.p50_us for mine, theirs in pairs if mine.p50_us and theirs.p50_us]
                if values:
                    yield f"{name}_{size}", statistics.median(values), "ratio"
            if lane.flood_ms:
                values = [mine.per_s / theirs.per_s for mine, theirs in pairs if mine.per_s and theirs.per_s]
                if values:
                    yield f"{name}_msgs_per_s_{size}", statistics.median(values), "ratio"

    def write_runs(self, path):
        """Every run of every lane as one line."""
        with open(path, "w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(["round", "peer", "mode", "size_bytes", "paced", "arrived", "lost", "p50_us", "mean_us",
                            "p99_us", "msgs_per_s", "flood_lost_percent"])
            for number, one in enumerate(self.rounds):
                for mode, lanes in one.items():
                    for found in lanes:
                        values = found.latencies_us
                        numbers = (found.p50_us, statistics.fmean(values), percentile(values, 0.99)) if values else \
                            ("", "", "")
                        table.writerow([number, mode.peer, mode.name, found.lane.size, int(found.lane.paced),
                                        len(values), found.lost, *numbers, found.per_s, found.flood_lost_percent])
