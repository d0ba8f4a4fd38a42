# Sourced by bench/NAME/run. Reads its arguments (--quick, --csv). Prints the "metric,value,unit" lines as they are, or
# as a table; in full mode with plots beside it in $results.
set -euo pipefail

build=${HGROS_BUILD_DIR:?Start this through ./dev bench}
quick=
csv=
for argument in "$@"; do
  case $argument in
    --quick) quick=--quick ;;
    --csv) csv=1 ;;
    *) echo "Unknown argument \"$argument\". The benchmarks take --quick and --csv." >&2; exit 2 ;;
  esac
done
mkdir -p "$(dirname -- "$0")/../results/$question"
results=$(cd -- "$(dirname -- "$0")/../results/$question" && pwd)

# All other files of a benchmark and its sessions are in a folder that this script deletes at its end.
scratch=$(mktemp -d "${TMPDIR:-/tmp}/hgros_bench_XXXXXX")
trap 'rm -rf -- "$scratch"' EXIT
export TMPDIR=$scratch XDG_RUNTIME_DIR=$scratch
unset HGROS_DOMAIN  # Each benchmark chooses its own domains.

machine() {
  printf '`./dev bench %s%s`, %s: %s, %s CPUs, %s, %s; load before: %s\n' \
    "$question" "${quick:+ $quick}" "$(date -u +%F)" \
    "$(sed -n 's/^model name[^:]*: *//p' /proc/cpuinfo | head -1)" "$(nproc)" \
    "$(sed -n 's/^PRETTY_NAME="\(.*\)"/\1/p' /etc/os-release)" "$(uname -r)" "$(cut -d' ' -f1 /proc/loadavg)"
}

# relay COMMAND...: runs it in its own process group, and shows the lines that it writes. Ctrl-C and SIGTERM end the
# whole group before they end this script. The output of a complete run becomes $results/result.csv.
relay() {
  local code=0 showing
  measuring=
  ended=
  trap 'ended=1; [[ -z $measuring ]] || kill -TERM -- "-$measuring" 2> /dev/null || true' INT TERM HUP
  machine > "$scratch/machine.txt"
  [[ -n $csv ]] || cat "$scratch/machine.txt"
  mkfifo "$scratch/lines"
  show < "$scratch/lines" &
  showing=$!
  set -m
  "$@" < /dev/null > "$scratch/lines" &
  measuring=$!
  set +m
  [[ -z $ended ]] || kill -TERM -- "-$measuring"
  wait "$measuring" || code=$?
  while kill -0 "$measuring" 2> /dev/null; do
    code=0
    wait "$measuring" || code=$?
  done
  kill -KILL -- "-$measuring" 2> /dev/null || true
  wait "$showing" || true
  trap - INT TERM HUP
  if [[ -n $ended ]] || (( code != 0 )); then exit $(( code != 0 ? code : 143 )); fi
  mv -- "$scratch"/*.csv "$scratch/machine.txt" "$results/"
  if [[ -z $csv && -z $quick ]]; then plot; fi
}

# show: standard input to the terminal
show() {
  if [[ -n $csv ]]; then
    tee "$scratch/result.csv"
    return
  fi
  printf '%-42s %14s  %s\n' metric value unit
  tee "$scratch/result.csv" | awk -F, '{ printf "%-42s %14s  %s\n", $1, $2, $3; fflush() }'
}

# plot: draws each family NAME_1KB_us ... NAME_4MB_us of the result as a line over message size
plot() {
  command -v gnuplot > /dev/null || { echo "No plots: gnuplot is not installed." >&2; return; }
  local families family lines=()
  mapfile -t families < <(sed -nE 's/^(.*_)1KB_us,.*/\1/p' "$results/result.csv")
  (( ${#families[@]} > 0 )) || return 0
  for family in "${families[@]}"; do
    awk -F, -v family="$family" '
      index($1, family) == 1 {
        size = substr($1, length(family) + 1)
        if (size !~ /^[0-9]+(KB|MB)_us$/) next
        bytes = size + 0
        if (size ~ /MB/) bytes *= 1024
        print bytes, $2
      }' "$results/result.csv" > "$results/$family.dat"
    lines+=("'$results/$family.dat' using 1:2 with linespoints title '${family//_/ }'")
  done
  gnuplot <<PLOT
set terminal pngcairo size 1000,650
set output '$results/latency.png'
set logscale xy
set grid
set key left top
set xlabel 'message size, KB'
set ylabel 'one-way latency, median, us'
plot $(IFS=,; echo "${lines[*]}")
PLOT
  echo "Plot: $results/latency.png"
}
