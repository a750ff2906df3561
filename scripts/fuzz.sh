#!/usr/bin/env bash
# Looks for input that breaks a promise of msd, by libFuzzer.
#
#   scripts/fuzz.sh [TARGET] [SECONDS]    one target, or each in turn; 1200 s by default
#
# Needs a nightly compiler, a C++ compiler and `cargo install cargo-fuzz`. New inputs are kept in
# fuzz/found/TARGET (not in the repository), those that fail in fuzz/artifacts/TARGET. To keep the
# best of what was found as seeds: cd fuzz && cargo +nightly fuzz cmin TARGET corpus/TARGET ...
# CI needs none of this: `scripts/check.sh test` runs mutations of the corpus and random bytes in a
# plain test.
set -euo pipefail
cd "$(dirname "$0")/../fuzz"

targets=$(cargo +nightly fuzz list)
[ $# -eq 0 ] || targets=$1
seconds=${2:-1200}
for target in $targets; do
    mkdir -p "found/$target"
    echo "fuzz: $target for $seconds s"
    # No input of 4 kB may take half a gigabyte. A step of dormand-prince may try a million substeps,
    # which takes a minute here where other programs run beside it.
    cargo +nightly fuzz run "$target" "found/$target" "corpus/$target" -- \
        -max_total_time="$seconds" -max_len=4096 -timeout=600 -malloc_limit_mb=400 \
        -print_final_stats=1
done
