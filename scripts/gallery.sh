#!/usr/bin/env bash
# Makes docs/reference/gallery.md anew: a picture of every built-in scene, with its line.
#
# Needs a graphics adapter (mesa-vulkan-drivers will do) and cwebp (apt install webp). Another msd
# than that of `cargo run --release` is taken from MSD.
set -euo pipefail
cd "$(dirname "$0")/.."

# When a scene looks best, seconds; the others after one.
moment() {
    case $1 in
        bunny) echo 0.9 ;;
        chain) echo 0.4 ;;
        cloth) echo 2.5 ;;
        curtain) echo 1.8 ;;
        dice) echo 0.9 ;;
        drape) echo 3 ;;
        flag) echo 3 ;;
        foam) echo 0.9 ;;
        gripper) echo 3 ;;
        jelly) echo 1.65 ;;
        funnel) echo 0.55 ;;
        knot) echo 0.5 ;;
        mattress) echo 1.5 ;;
        pile) echo 4 ;;
        snake) echo 8.5 ;;
        square) echo 1.5 ;;
        square4) echo 1.4 ;;
        stairs) echo 1.2 ;;
        teapot) echo 0.45 ;;
        trampoline) echo 0.75 ;;
        twist) echo 2.5 ;;
        *) echo 1 ;;
    esac
}

msd=${MSD:-cargo run --quiet --release --}
folder=docs/reference/gallery
pictures=$(mktemp -d)
trap 'rm -r "$pictures"' EXIT
mkdir -p $folder
rm -f $folder/*.webp
{
    echo '# Gallery'
    echo
    echo 'Every built-in scene. Open one with `msd view NAME`. `scripts/gallery.sh` renews the pictures.'
    echo 'The key [`look`](scenes.md#look) sets the appearance of bodies.'
    echo
    echo '| | |'
    echo '|---|---|'
} > docs/reference/gallery.md
row=
while read -r name title; do
    $msd render "$name" --time "$(moment "$name")" --size 960x540 --quiet --out "$pictures/$name.png"
    cwebp -quiet -q 80 -m 6 -resize 640 0 "$pictures/$name.png" -o "$folder/$name.webp"
    cell="![$name](gallery/$name.webp) <br> **$name**: $title"
    if [ -z "$row" ]; then
        row="| $cell |"
    else
        echo "$row $cell |" >> docs/reference/gallery.md
        row=
    fi
done < <($msd scenes)
[ -z "$row" ] || echo "$row |" >> docs/reference/gallery.md
du -cb $folder/*.webp | tail -1
