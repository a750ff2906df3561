#!/usr/bin/env bash
# Builds msd as a page for browsers, into web/dist: static files that ask nobody else for anything.
#
#   scripts/web.sh            builds and says how large it is
#   scripts/web.sh --serve    builds, and serves it at http://127.0.0.1:8080 (PORT=... elsewhere)
#   PAGE_ADDRESS=https://.../ scripts/web.sh   names the picture that previews of links show
set -euo pipefail
cd "$(dirname "$0")/.."

page=web/page dist=web/dist built=target/web/wasm32-unknown-unknown/web/msd.wasm
# What a visitor may have to load, compressed, bytes.
limit=5000000

(
    eval "$(TOOLCHAIN_TARGETS=wasm32-unknown-unknown sh scripts/wasm-toolchain.sh .toolchain)"
    # The loops of a step take registers of 128 bits, which every browser of today has.
    # A stack of 4 MB, half of what the window has elsewhere; the default is 1 MB.
    RUSTFLAGS="-Ctarget-feature=+simd128 -Clink-arg=-zstack-size=4194304" cargo build --profile web -p msd-app --bin msd \
        --target-dir target/web $WASM_CARGO_ARGS
)
rm -rf "$dist"
mkdir -p "$dist"
cargo run -q --manifest-path web/bind/Cargo.toml --target-dir target/bind -- "$built" "$dist"
if command -v wasm-opt >/dev/null; then
    wasm-opt -O2 "$dist/msd_bg.wasm" -o "$dist/msd_bg.wasm"
    # The version of Debian 12 and Ubuntu 24.04 exports the first table whichever was meant; that of
    # objects of JavaScript is the second.
    case $(wasm-opt --version) in
    *" version 108"*)
        LC_ALL=C sed -i 's/\(__wbindgen_externrefs\x01\)\x00/\1\x01/' "$dist/msd_bg.wasm"
        ;;
    esac
else
    echo "web: larger than need be without wasm-opt (install it with: apt install binaryen)"
fi

cp "$page"/* "$dist"
size=$(wc -c <"$dist/msd_bg.wasm")
# A preview of a link shows a picture only by its whole address.
sed -i "s/SIZE_OF_PROGRAM/$size/; s|ADDRESS_OF_PAGE|${PAGE_ADDRESS:-}|" "$dist/index.html"
files=$(cd "$dist" && ls | grep -v '^sw.js$' | sed 's/.*/"&"/' | paste -sd,)
version=$(cat "$dist"/* | sha256sum | cut -c1-16)
sed -i "s/VERSION_OF_FILES/$version/; s/LIST_OF_FILES/[\".\\/\",$files]/" "$dist/sw.js"

raw=0 packed=0
for file in "$dist"/*; do
    plain=$(wc -c <"$file") small=$(gzip -9c "$file" | wc -c)
    raw=$((raw + plain)) packed=$((packed + small))
    printf 'web: %-24s %9d bytes, %9d compressed\n' "${file#web/}" "$plain" "$small"
done
printf 'web: %-24s %9d bytes, %9d compressed\n' "all" "$raw" "$packed"
if [ "$packed" -gt "$limit" ]; then
    echo "web: more than $limit bytes compressed" >&2
    exit 1
fi

if [ "${1:-}" = --serve ]; then
    if ! command -v python3 >/dev/null; then
        echo "web: it takes python3 to serve it (or any other server of the files in $dist)" >&2
        exit 1
    fi
    echo "web: http://127.0.0.1:${PORT:-8080}"
    exec python3 -m http.server --bind 127.0.0.1 --directory "$dist" "${PORT:-8080}"
fi
