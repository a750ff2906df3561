#!/usr/bin/env bash
# Everything CI checks. Run it from anywhere.
#
#   scripts/check.sh          all of it
#   scripts/check.sh STEP...  some of it: fmt clippy doc test release examples bench bare elsewhere
#                             python wasm web package deny; and wheels and miri, which are not part
#                             of "all"
set -euo pipefail
cd "$(dirname "$0")/.."

fmt() {
    cargo fmt --all --check
    cargo fmt --manifest-path bare/Cargo.toml --check
    cargo fmt --manifest-path crates/msd-py/Cargo.toml --check
    cargo fmt --manifest-path fuzz/Cargo.toml --check
    cargo fmt --manifest-path web/bind/Cargo.toml --check
}
# And the command line without the window, for machines that have no screen.
clippy() {
    cargo clippy --workspace --all-targets -- -D warnings
    cargo clippy -p msd-app --no-default-features --bin msd -- -D warnings
}
doc() { RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps; }
# As the programs of a release are built; builds with other features share little.
features=(--features "msd-app/accessibility msd-app/parquet" --config scripts/tests.toml)
# With thousands of mutations of each corpus of the fuzz targets; `scripts/fuzz.sh` goes on.
test_debug() {
    MSD_MUTATIONS=5000 cargo test --no-fail-fast "${features[@]}"
}
# Where optimisation could matter: what has the same bits here does the same in all else.
test_release() { cargo test --release --test kernel --test same_bits --test threads; }

# Every example but the window, which tests/window/ of the app drives in its stead. Not optimised
# beyond the core, as the tests have compiled all that they need.
examples() {
    local out
    out=$(mktemp -d)
    cargo build --examples "${features[@]}"
    for example in hello_spring own_element own_obstacle own_method grow half_stiffer no_std_step; do
        "target/debug/examples/$example" >"$out/$example.txt"
        [ -s "$out/$example.txt" ]
    done
    target/debug/examples/soak chain 120 >"$out/soak.txt"
    grep -q '^2,' "$out/soak.txt"
    for example in chain_plot falling_square stability_table; do
        "target/debug/examples/$example" "$out/$example.svg"
        grep -q '</svg>' "$out/$example.svg"
    done
    rm -r "$out"
}

# Each benchmark once: that it runs, not how fast, and so as the tests were compiled. And the
# instructions of a step, counted, optimised.
bench() {
    local name
    for name in step performance stability promise trade gpu; do
        MSD_CACHE= cargo bench --profile dev --bench "$name" "${features[@]}" -- --test
    done
    cargo bench --bench instructions
}

# The core on bare metal, with an allocator and nothing else: the same bits in an emulator.
bare() {
    (
        eval "$(sh scripts/wasm-toolchain.sh .toolchain)"
        cd bare
        bare_cargo() { cargo "$1" --release --locked --target-dir ../target/bare $BARE_CARGO_ARGS; }
        bare_cargo build
        if ! command -v qemu-system-arm >/dev/null; then
            echo "check: SKIPPED the emulator (install it with: apt install qemu-system-arm)"
            [ -z "${MSD_REQUIRE_EMULATOR:-}" ]
            return
        fi
        bare_cargo run >../target/bare/hashes.txt
        diff <(grep -E '^(chain|(rough|square) .* f32) ' ../crates/msd-run/tests/hashes.txt |
            sort -u) <(sort ../target/bare/hashes.txt)
        echo "check: $(wc -l <../target/bare/hashes.txt) runs end in the same bits as here"
    )
}

# The kernel with NEON, in an emulator, and in plain Rust with 32 bits of address: the same bits.
elsewhere() {
    local neon=aarch64-unknown-linux-musl plain=i686-unknown-linux-musl target
    if ! timeout 300 rustup target add "$neon" "$plain"; then
        echo "check: SKIPPED elsewhere (it needs the targets $neon and $plain, which rustup has)"
        return
    fi
    if ! command -v qemu-aarch64 >/dev/null; then
        echo "check: SKIPPED elsewhere (install it with: apt install qemu-user)"
        [ -z "${MSD_REQUIRE_EMULATOR:-}" ]
        return
    fi
    for target in "$neon" "$plain"; do
        CARGO_TARGET_AARCH64_UNKNOWN_LINUX_MUSL_RUNNER=qemu-aarch64 \
            cargo test -p msd-core --test kernel --target "$target" \
            --config "target.$target.linker='rust-lld'" \
            --config "target.$target.rustflags=['-Clink-self-contained=yes']"
    done
}

# The kernel, with AVX2 where its one `unsafe` line is, in an interpreter that finds undefined
# behaviour: a nightly compiler with Miri, some five minutes.
miri() {
    if ! cargo +nightly miri --version >/dev/null 2>&1; then
        echo "check: SKIPPED miri (rustup toolchain install nightly -c miri -c rust-src)"
        [ -z "${MSD_REQUIRE_MIRI:-}" ]
        return
    fi
    RUSTFLAGS=-Ctarget-cpu=x86-64-v3 MIRIFLAGS=-Zmiri-disable-isolation \
        cargo +nightly miri test -p msd-core --test kernel --target-dir target/miri \
        -- forces_have lattices_of_all
}

# Every library must stay fit for the browser, without warnings, and the core for one with registers
# of 128 bits.
wasm() {
    (
        eval "$(sh scripts/wasm-toolchain.sh .toolchain)"
        RUSTFLAGS=-Dwarnings cargo check --lib -p msd-springs -p msd-core -p msd-scene -p msd-run -p msd-study \
            -p msd-report -p msd-render -p msd-gpu -p msd-film -p msd-app $WASM_CARGO_ARGS
        RUSTFLAGS=-Ctarget-feature=+simd128 cargo build --lib -p msd-core \
            --config profile.dev.package.msd-core.opt-level=1 $WASM_CARGO_ARGS
    )
}

# The page for browsers: its size, and what it does in one.
web() {
    scripts/web.sh
    scripts/web-test.sh
}

# The CPythons at hand, the oldest first. With pyenv, all that it has installed.
pythons() {
    local version
    ! command -v pyenv >/dev/null || export PYENV_VERSION=$(pyenv versions --bare | paste -sd :)
    for version in 3.10 3.11 3.12 3.13 3.14; do
        ! "python$version" -c 'import venv, ensurepip, sys; print(sys.executable)' 2>/dev/null
    done
}

# Whether there is any; without one, what to install.
need_python() {
    [ $# -eq 0 ] || return 0
    echo "check: SKIPPED python (install it with: apt install python3.11-venv)"
    [ -z "${MSD_REQUIRE_PYTHON:-}" ] && return 1
    exit 1
}

# The Python module: a plain wheel, compiled as the tests were, with its examples and types, on the
# newest CPython at hand. `wheels` tests it as it is given away.
python() {
    local interpreters out
    mapfile -t interpreters < <(pythons)
    need_python "${interpreters[@]}" || return 0
    out=$(mktemp -d)
    "${interpreters[-1]}" -m venv "$out/venv"
    local PATH="$out/venv/bin:$PATH"
    python3 -m pip install -q "maturin>=1.16,<2" numpy pytest mypy
    maturin build --profile dev --locked --quiet --strip --target-dir target \
        --config scripts/tests.toml -i python3 -o "$out"
    python3 -m pip install -q "$out"/*.whl
    [ ! -x target/debug/msd ] || local -x MSD=$PWD/target/debug/msd
    # A plain build draws nothing, with any driver.
    env -u MSD_REQUIRE_ADAPTER python3 -m pytest -q -rs -p no:cacheprovider crates/msd-py/tests
    python3 -m mypy --strict examples/python
    python3 examples/python/pull_test.py >/dev/null
    rm -r "$out"
}

# A wheel with all features, built once as it is given away, and its tests on the oldest and the
# newest CPython at hand, with the oldest and the newest numpy, and all engines of sweeps.
wheels() {
    local interpreters version wheel out pip
    mapfile -t interpreters < <(pythons)
    need_python "${interpreters[@]}" || return 0
    cargo build "${features[@]}" --bin msd
    out=$(mktemp -d)
    "${interpreters[-1]}" -m venv "$out/newest"
    pip="$out/newest/bin/python -m pip install -q"
    $pip "maturin>=1.16,<2" numpy pytest matplotlib joblib distributed
    $pip ray || echo "check: SKIPPED ray (it cannot be installed for ${interpreters[-1]})"
    PATH="$out/newest/bin:$PATH" CARGO_TARGET_DIR=target/python maturin build --release --locked \
        --quiet --features abi3,pictures,report -i "${interpreters[-1]}" -o "$out"
    wheel=$(echo "$out"/*.whl)
    for version in abi3 abi3,pictures,report; do
        CARGO_TARGET_DIR=target/python cargo clippy --release --locked --features "$version" \
            --manifest-path crates/msd-py/Cargo.toml -- -D warnings
    done
    "${interpreters[0]}" -m venv "$out/oldest"
    "$out/oldest/bin/python" -m pip install -q pytest "numpy==1.24.*; python_version < '3.12'" numpy
    for version in oldest newest; do
        "$out/$version/bin/python" -m pip install -q "$wheel"
        MSD=$PWD/target/debug/msd "$out/$version/bin/python" -m pytest -q -rs -p no:cacheprovider \
            crates/msd-py/tests
    done
    # Without the lock of the interpreter: PyO3 wants 3.14 or later, and a build of its own.
    if python3.14t -c 'import venv, ensurepip' 2>/dev/null; then
        python3.14t -m venv "$out/free"
        "$out/free/bin/python" -m pip install -q "maturin>=1.16,<2" numpy pytest
        "$out/free/bin/python" -m pip install -q .
        "$out/free/bin/python" -m pytest -q -rs -p no:cacheprovider crates/msd-py/tests
    else
        echo "check: SKIPPED the free-threaded build (it needs a python3.14t)"
    fi
    rm -r "$out"
}

# What a registry would get of each library and of the program.
package() { cargo package --quiet --workspace --exclude xtask --no-verify --allow-dirty; }

# Licences and advisories need a tool and a database that a bare machine lacks.
deny() {
    if command -v cargo-deny >/dev/null; then
        cargo deny check licenses bans sources
    else
        echo "check: SKIPPED deny (install it with: cargo install cargo-deny)"
    fi
}

# With the seconds that processors worked: the wall clock of a busy machine says little.
run() {
    echo "check: $1"
    local TIMEFORMAT="check: $1 took %0R s, in which processors worked %0U s, and %0S s for the system"
    time "$2"
}

each() {
    local step
    for step in "$@"; do
        case $step in
        fmt | clippy | doc | examples | bench | bare | elsewhere | miri | package | python | wasm | web | wheels | deny) run "$step" "$step" ;;
        test | release) run "$step" "test_$([ "$step" = test ] && echo debug || echo release)" ;;
        *)
            echo "check: unknown step $step" >&2
            exit 2
            ;;
        esac
    done
}

# Some steps, and beside them others, up to a `--`, which come second where both want a core.
beside() {
    local others=() log failed= id
    for step; do
        shift
        [ "$step" != -- ] || break
        others+=("$step")
    done
    log=$(mktemp)
    (
        renice -n 10 $BASHPID >/dev/null
        each "${others[@]}"
    ) >"$log" 2>&1 &
    id=$!
    # In the background too: within a condition no failure would end it.
    (each "$@") &
    wait $! || failed=1
    wait "$id" || failed=1
    cat "$log"
    rm "$log"
    [ -z "$failed" ]
}

if [ $# -gt 0 ]; then
    each "$@"
else
    each fmt
    # Tests wait for a quarter of their time, and browsers for a third.
    beside release wasm clippy doc -- test
    each examples bench
    beside python bare elsewhere package deny -- web
fi
echo "check: all done"
