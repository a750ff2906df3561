#!/usr/bin/env bash
# Makes the pictures of docs/tutorial/ anew (a grab, and the first five minutes), those of
# docs/reference/ and docs/explanation/materials.md, and of the page. They are filmed without a
# display, always the same frames.
#
# Needs a graphics adapter (mesa-vulkan-drivers will do), img2webp and cwebp (apt install webp), and
# montage (apt install imagemagick).
set -euo pipefail
cd "$(dirname "$0")/.."

frames=$(mktemp -d)
trap 'rm -r "$frames"' EXIT
MSD_FILM=$frames cargo test --release -p msd-app --test all -- --ignored film_of_a_grab
# Every second frame: 15 pictures a second.
img2webp -loop 0 -lossy -q 55 -m 4 -d 66 "$frames"/*[02468].png -o docs/tutorial/grab.webp
ls -l docs/tutorial/grab.webp

# The five pictures of the first five minutes, each step of the guide with the real controls.
MSD_FILM=$frames cargo test --release -p msd-app --test all -- --ignored pictures_of_the_first_five_minutes
mkdir -p docs/tutorial/first
for step in grab stiffen blow-up mend cost; do
    cwebp -quiet -q 70 -resize 900 0 "$frames/$step.png" -o "docs/tutorial/first/$step.webp"
done
ls -l docs/tutorial/first

# The scene drape, of docs/reference/scenes.md.
cargo run --release -- render drape --time 3 --out "$frames/drape.png"
cwebp -quiet -q 70 -resize 640 0 "$frames/drape.png" -o docs/reference/drape.webp

# What the page of a browser shows while it loads, and previews of links to it.
cargo run --release -- render cube --time 1.5 --size 640x400 --out "$frames/still.png"
cwebp -quiet -q 75 "$frames/still.png" -o web/page/still.webp

# The scenes of things that touch, of docs/reference/command-line.md.
for scene in trampoline:1.6 twist:2.5 funnel:0.6 knot:0.4 curtain:1.8 stairs:1.2; do
    cargo run --release -- render "${scene%:*}" --time "${scene#*:}" --size 400x300 \
        --out "$frames/${scene%:*}.png"
done
montage "$frames"/{trampoline,twist,funnel,knot,curtain,stairs}.png -tile 3x2 -geometry +2+2 \
    "$frames/touching.png"
cwebp -quiet -q 75 "$frames/touching.png" -o docs/reference/touching.webp
ls -l docs/reference/touching.webp

# The three scenes of docs/explanation/materials.md.
cargo run --release -- render docs/explanation/materials/gelatine.toml --time 0.125 --size 400x300 \
    --out docs/explanation/materials/gelatine.png
cargo run --release -- render docs/explanation/materials/denim.toml --time 2 --size 400x300 \
    --out docs/explanation/materials/denim.png
cargo run --release -- render docs/explanation/materials/shells.toml --time 0.6 --size 400x225 \
    --pitch-deg 10 --out docs/explanation/materials/shells.png
ls -l docs/explanation/materials
