#!/bin/sh
# Checks that the layers of ARCHITECTURE.md are used in one direction only. Prints every violation; exits 1 if there is one.
set -u
cd "$(dirname "$0")/.." || exit 1
bad=0
complain() { printf '%s\n' "$1"; bad=1; }

# Crates: each may depend only on those named here.
allowed() {
    case "$1" in
        eikona-mesh | eikona-numeric) echo "" ;;
        eikona) echo "eikona-mesh eikona-numeric" ;;
        eikona-render) echo "eikona-mesh" ;;
        eikona-scene) echo "eikona eikona-mesh" ;;
        eikona-cli) echo "eikona eikona-mesh eikona-render eikona-scene" ;;
        *) echo "unknown" ;;
    esac
}
for manifest in crates/*/Cargo.toml; do
    crate=$(basename "$(dirname "$manifest")")
    may=$(allowed "$crate")
    [ "$may" = unknown ] && complain "$crate: not in scripts/check_layers.sh; say what it may depend on"
    # Only [dependencies]: tests may use what they like.
    for dependency in $(awk '/^\[/ { on = ($0 == "[dependencies]") } on && /^eikona/ { sub(/[ .=].*/, ""); print }' "$manifest"); do
        case " $may " in *" $dependency "*) ;; *) complain "$manifest: $crate must not depend on $dependency" ;; esac
    done
done

# Modules of the library: what each folder must not name.
forbid() { # folder, pattern, reason
    [ -d "crates/eikona/src/$1" ] || return 0
    found=$(grep -rnE "$2" "crates/eikona/src/$1" --include='*.rs' | grep -vE '^[^:]+:[0-9]+: *//')
    [ -n "$found" ] && complain "$3:
$found"
}
methods='signed_heat|winding|polar_field|repulsive'
curves='curves|cut|contour'
forbid geometry "crate::(operators|spatial|$curves|$methods)" "geometry must not use layers above it"
for layer in operators spatial curves cut contour; do
    forbid $layer "crate::($methods)" "$layer must not use a method"
done
for layer in spatial curves cut contour; do
    forbid $layer "crate::operators" "$layer knows no matrices"
    others=$(echo "$curves" | tr '|' '\n' | grep -v "^$layer\$" | paste -sd '|' -)
    forbid $layer "crate::($others)" "$layer must not use $others"
done
forbid spatial "\\b(Graph|Symbolic|Cholesky|SymmetricMatrix|HalfSolution|ConjugateGradient)\\b" "spatial knows no matrices"
for method in signed_heat winding polar_field repulsive; do
    others=$(echo "$methods" | tr '|' '\n' | grep -v "^$method\$" | paste -sd '|' -)
    forbid $method "crate::($others)" "a method must not use another method"
done
# The linear-algebra backend stays inside eikona-numeric: no other crate names or depends on it, and
# nothing public there is an alias of its types.
backend='faer|nalgebra|ndarray|gemm|pulp'
found=$(grep -rnE "\\b($backend)\\b" crates/*/src --include='*.rs' | grep -vE '^crates/eikona-numeric/|:[0-9]+: *//')
[ -n "$found" ] && complain "the backend is hidden by eikona-numeric:
$found"
found=$(grep -nE "^($backend)\\b" crates/*/Cargo.toml | grep -v '^crates/eikona-numeric/')
[ -n "$found" ] && complain "only eikona-numeric depends on the backend:
$found"
found=$(grep -rnE "pub (use|type|const)\\b.*\\b($backend)::" crates/eikona-numeric/src --include='*.rs')
[ -n "$found" ] && complain "public items of eikona-numeric do not name the backend:
$found"
# Names that say nothing.
found=$(find crates -path '*/src/*' | grep -E '/(utils?|common|helpers?|misc|core|manager)(\.rs)?$')
[ -n "$found" ] && complain "find a better name:
$found"
[ $bad = 0 ] && echo "layers: in order"
exit $bad
