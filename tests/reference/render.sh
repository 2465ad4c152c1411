#!/bin/sh
# Draws the shipped capture with an independent public renderer, splat-transform of PlayCanvas (MIT), and compares with
# the pictures of this project:
#
#   tests/reference/render.sh [--store] [FOLDER]
#
# Needs node 20 or newer with npm, a Vulkan driver that Dawn takes (a graphics card, or SwiftShader as Debian's `chromium`
# brings it), and `cargo`. What is missing is said, and then only the stored pictures are compared, which
# `cargo test --release --test stored` always does. FOLDER keeps what was installed and drawn; `--store` puts the new
# pictures in place of the stored ones. A picture takes some ten minutes of processor time without a graphics card.
set -eu

version=2.7.1
root=$(cd "$(dirname "$0")/../.." && pwd)
store=no
if [ "${1:-}" = --store ]; then store=yes; shift; fi
place=${1:-$(mktemp -d)}
mkdir -p "$place"
place=$(cd "$place" && pwd)

missing() {
    echo "skipped: $1; comparing the stored pictures alone" >&2
    cd "$root" && exec cargo test --release --test stored -- --nocapture
}

command -v npm >/dev/null || missing "npm is not installed"
cd "$place"
[ -d node_modules/@playcanvas/splat-transform ] ||
    npm install --no-audit --no-fund "@playcanvas/splat-transform@$version" >npm.log 2>&1 ||
    missing "splat-transform $version cannot be installed, see $place/npm.log"
if [ -z "${VK_ICD_FILENAMES:-}" ] && [ -f /usr/lib/chromium/vk_swiftshader_icd.json ]; then
    export VK_ICD_FILENAMES=/usr/lib/chromium/vk_swiftshader_icd.json
fi
export XDG_RUNTIME_DIR="$place"

# Name and place of the camera in the axes of that program: those of the file with x and z turned round.
draw() {
    [ ! -f "$place/$1.webp" ] || return 0
    npx splat-transform -w -g 0 "$root/launch/scenes/assets/plant.v4.spz" --camera "$2" --look-at 0,0,0 --up 0,1,0 \
        --fov 45 --resolution 240x320 "$place/$1.webp" >"$place/$1.log" 2>&1 ||
        missing "splat-transform cannot draw, see $place/$1.log"
}
draw plant-front 0,0,1.6
draw plant-side 1.2,0.5,-0.7

[ "$store" = no ] || cp "$place/plant-front.webp" "$place/plant-side.webp" "$root/viewer/tests/pictures/"
cd "$root"
COSPLAT_REFERENCE="$place" exec cargo test --release --test stored -- --nocapture
