#!/bin/sh
# Runs every fuzz target for some seconds (default 60): sh scripts/fuzz.sh [seconds [target...]]
# Prints a line a target; exits 1 if one crashed, hung for 10 s or took more than 2 GiB. What broke it lies in fuzz/artifacts.
# Needs a C++ compiler for libFuzzer. The stable toolchain does: no sanitizer is used, the code has no unsafe blocks of its own.
set -eu
cd "$(dirname "$0")/.."
seconds=${1:-60}
[ $# -gt 0 ] && shift
export RUSTC_BOOTSTRAP=1

if ! cargo fuzz --version >/dev/null 2>&1; then
    cargo install cargo-fuzz --locked || cargo install cargo-fuzz
fi
targets=${*:-$(cargo fuzz list)}
logs=$(mktemp -d)
trap 'rm -rf "$logs"' EXIT
bad=0
for target in $targets; do
    if ! cargo fuzz build --sanitizer none "$target" >"$logs/build" 2>&1; then
        cat "$logs/build"
        exit 1
    fi
    mkdir -p "fuzz/corpus/$target" "fuzz/seeds/$target"
    status=0
    # New inputs go to the first folder; the seeds are only read.
    cargo fuzz run --sanitizer none "$target" "fuzz/corpus/$target" "fuzz/seeds/$target" -- \
        -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 -seed=1 -len_control=0 \
        >"$logs/$target" 2>&1 || status=$?
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$logs/$target" | tail -n 1)
    if [ "$status" -eq 0 ]; then
        printf '%-12s %10s runs, 0 crashes\n' "$target" "${runs:-?}"
    else
        bad=1
        printf '%-12s %10s runs, 1 crash\n' "$target" "${runs:-?}"
        # The message of the panic or of libFuzzer, and the file to reproduce it with.
        grep -E -A 3 'panicked at|^==[0-9]+== ERROR|Test unit written' "$logs/$target" | cut -c 1-400 | head -n 20 || true
    fi
done
exit $bad
