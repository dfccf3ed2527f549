#!/bin/bash
# Makes the pictures of docs/effects/ambient-occlusion.md again: the stages and the presets on one built-in scene.
#   tools/occlusion_pictures.sh [FOLDER]     (docs/pictures)
set -euo pipefail
cd "$(dirname "$0")/.."
sfumato=build/release/bin/sfumato
folder=${1:-docs/pictures}
scene=interior
size=320x180
[ -x "$sfumato" ] || { echo "$sfumato is missing: run ./dev build" >&2; exit 1; }
mkdir -p "$folder"

picture() { # name, options of render
  local name=$1
  shift
  "$sfumato" render $scene -o "$folder/ao-$name.png" --size $size -q "$@"
}

picture off
picture on --effects ambient-occlusion --preset high --set application=ambient
picture truth --truth ambient-occlusion --truth-rays 1024
for view in depth normal mip radius estimate; do
  picture "view-$view" --effects ambient-occlusion --preset high --set debug_view=$view
done
for preset in $("$sfumato" list presets ambient-occlusion --json | sed -n 's/.*"name": "\([a-z0-9-]*\)".*/\1/p'); do
  picture "preset-$preset" --effects ambient-occlusion --preset "$preset" --preroll 8
done
