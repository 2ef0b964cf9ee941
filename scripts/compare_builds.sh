#!/bin/sh
# Compares the digits of two builds of the command on all files of the data folder:
#     sh scripts/compare_builds.sh OLD/eikona NEW/eikona [data folder]
# Solves `sdf` from a vertex on every mesh, and `sdf` and `winding` for every curve file. Prints each
# output that differs, and the counts; exits 1 if one differs.
set -u
old=$1 new=$2
data=${3:-$(dirname "$0")/../../shared/data}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
run=0 differ=0

# compare NAME arguments...: the output is a file of numbers at full precision, or an exit code.
compare() {
    name=$1
    shift
    for build in old new; do
        program=$old
        [ $build = new ] && program=$new
        rm -f "$work/$build.csv"
        "$program" "$@" -q -o "$work/$build.csv" >/dev/null 2>&1
        echo "exit $?" >>"$work/$build.csv"
    done
    run=$((run + 1))
    if ! cmp -s "$work/old.csv" "$work/new.csv"; then
        differ=$((differ + 1))
        echo "differs: $name"
    fi
}

for mesh in $(find "$data" \( -name '*.obj' -o -name '*.off' -o -name '*.ply' -o -name '*.stl' \) | sort); do
    compare "sdf ${mesh#"$data"/}" sdf "$mesh" --points 0
done
for curve in $(find "$data/curves" -name '*.txt' | sort); do
    name=$(basename "$curve" .txt)
    mesh=$(find "$data" -name "$name.obj" | head -n 1)
    case $name in bunny-*) mesh=$data/closed/bunny.obj ;; torus-phi) mesh=$data/curves/swn/torus.obj ;; esac
    [ -n "$mesh" ] || continue
    compare "sdf $name" sdf "$mesh" --curve "$curve"
    compare "winding $name" winding "$mesh" --curve "$curve"
done
echo "$run outputs compared, $differ differ"
[ $differ = 0 ]
