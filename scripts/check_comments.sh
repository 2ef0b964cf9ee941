#!/bin/sh
# Checks that comments are at most 100 columns wide, which rustfmt does not, and that no file has the
# marks of a merge. Prints every violation; exits 1 if there is one. Rows of tables are exempt:
# Markdown can not break them.
set -u
cd "$(dirname "$0")/.." || exit 1
wide=$(find crates fuzz/fuzz_targets fuzz/src -name '*.rs' -exec env LC_ALL=C.UTF-8 grep -nHE '^.{101,}$' {} + |
    grep -E ':[0-9]+:[[:space:]]*//|[;,{})] // ' | grep -vE '//[/!] \|')
if [ -n "$wide" ]; then
    printf 'comments wider than 100 columns:\n%s\n' "$wide"
    exit 1
fi
marks=$(find . \( -name target -o -name .git \) -prune -o -type f \( -name '*.rs' -o -name '*.md' -o -name '*.toml' -o -name '*.sh' \) \
    -exec grep -nHE '^(<<<<<<<|>>>>>>>)( |$)' {} +)
if [ -n "$marks" ]; then
    printf 'marks of a merge:\n%s\n' "$marks"
    exit 1
fi
echo "comments: in order"
