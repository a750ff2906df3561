#!/usr/bin/env bash
# Makes the moving picture of the README anew: a grab and a throw in the whole window, filmed without
# a display, always the same frames.
#
# Needs a graphics adapter (mesa-vulkan-drivers will do) and img2webp (apt install webp).
set -euo pipefail
cd "$(dirname "$0")/.."

frames=$(mktemp -d)
trap 'rm -r "$frames"' EXIT
MSD_FILM=$frames cargo test --release --test film -- --ignored film_of_a_grab
# Every second frame: 15 pictures a second.
img2webp -loop 0 -lossy -q 65 -m 4 -d 66 "$frames"/*[02468].png -o docs/grab.webp
ls -l docs/grab.webp
