#!/usr/bin/env bash
# Makes the pictures of the window in the README anew: a grab, and the first five
# minutes, and those of docs/scenes.md, docs/using.md and docs/materials.md, and of the page. They are
# filmed without a display, always the same frames.
#
# Needs a graphics adapter (mesa-vulkan-drivers will do), img2webp and cwebp (apt install webp), and
# montage (apt install imagemagick).
set -euo pipefail
cd "$(dirname "$0")/.."

frames=$(mktemp -d)
trap 'rm -r "$frames"' EXIT
MSD_FILM=$frames cargo test --release -p msd-app --test all -- --ignored film_of_a_grab
# Every second frame: 15 pictures a second.
img2webp -loop 0 -lossy -q 55 -m 4 -d 66 "$frames"/*[02468].png -o docs/grab.webp
ls -l docs/grab.webp

# The five pictures of the first five minutes, each step of the guide with the real controls.
MSD_FILM=$frames cargo test --release -p msd-app --test all -- --ignored pictures_of_the_first_five_minutes
mkdir -p docs/first
for step in grab stiffen blow-up mend cost; do
    cwebp -quiet -q 70 -resize 900 0 "$frames/$step.png" -o "docs/first/$step.webp"
done
ls -l docs/first

# The scene drape, of docs/scenes.md.
cargo run --release -- render drape --time 3 --out "$frames/drape.png"
cwebp -quiet -q 70 -resize 640 0 "$frames/drape.png" -o docs/drape.webp

# What the page of a browser shows while it loads, and previews of links to it.
cargo run --release -- render cube --time 1.5 --size 640x400 --out "$frames/still.png"
cwebp -quiet -q 75 "$frames/still.png" -o web/page/still.webp

# The scenes of things that touch, of docs/using.md.
for scene in trampoline:1.6 twist:2.5 funnel:0.6 knot:0.4 curtain:1.8 stairs:1.2; do
    cargo run --release -- render "${scene%:*}" --time "${scene#*:}" --size 400x300 \
        --out "$frames/${scene%:*}.png"
done
montage "$frames"/{trampoline,twist,funnel,knot,curtain,stairs}.png -tile 3x2 -geometry +2+2 \
    "$frames/touching.png"
cwebp -quiet -q 75 "$frames/touching.png" -o docs/touching.webp
ls -l docs/touching.webp

# The three scenes of docs/materials.md.
cargo run --release -- render docs/materials/gelatine.toml --time 0.125 --size 400x300 \
    --out docs/materials/gelatine.png
cargo run --release -- render docs/materials/denim.toml --time 2 --size 400x300 \
    --out docs/materials/denim.png
cargo run --release -- render docs/materials/shells.toml --time 0.6 --size 400x225 \
    --pitch-deg 10 --out docs/materials/shells.png
ls -l docs/materials
