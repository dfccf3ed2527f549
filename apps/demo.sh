#!/bin/bash
# Renders built-in scenes, blurs and shades them with several presets, measures the pictures against ground truth and leaves
# everything in demo/, with one page, demo/index.html, that holds all pictures itself. ./dev demo builds and calls this.
set -euo pipefail
cd "$(dirname "$0")/.."

sfumato=build/release/bin/sfumato
size=480x270
folder=demo
page=$folder/index.html
# Scene, sub-frames of its truth, and what to look at.
scenes=(
  "fairground|24|Rolling, spinning, swinging and sliding things before a camera that pans slowly. Look at the edges of what moves."
  "two-trains|16|Two trains pass each other: two opposite motions in the same tiles, at different depths, with gaps between the cars."
  "static-foreground|16|The wall behind rushes by, the things in front stand still: nothing may smear over them or out of them."
)
presets=(current-gen dx11 high)
views=(velocity neighbour-maximum tile-class)
# Ambient occlusion: one scene that does not take long.
occlusion_scene=contact
occlusion_presets=(current-gen hbao soma high)

fail() { printf 'demo: %s\n' "$*" >&2; exit 1; }
[ -x "$sfumato" ] || fail "$sfumato is missing: run ./dev build"

escape() { sed -e 's/&/\&amp;/g' -e 's/</\&lt;/g' -e 's/>/\&gt;/g' -e 's/"/\&quot;/g'; }

# Runs a command and keeps its text in $command, for the page.
command=""
run() {
  command="$*"
  "$@" -q
}

# "all / moving / still" of a picture in dB, as `sfumato compare` tells them.
decibels() {
  "$sfumato" compare "$1" "$2" --sharp "$3" |
    awk '{ value[$1] = $3 } END { printf "%s / %s / %s dB\n", value["all"], value["moving"], value["still"] }'
}

# One picture of the list: scene, short name, title, file. The command is the last one run.
picture() {
  local scene=$1 name=$2 title=$3 file=$4 measured=${5:-}
  printf '<figure><img id="%s-%s" alt="%s, %s" width="%s" height="%s" src="data:image/png;base64,' \
    "$scene" "$name" "$scene" "$title" "${size%x*}" "${size#*x}"
  base64 -w 0 "$file"
  printf '">\n<figcaption><b>%s</b>%s<code>%s</code></figcaption></figure>\n' \
    "$title" "${measured:+<span>$measured</span>}" "$(printf '%s' "$command" | escape)"
}

head_of_page() {
  cat <<HTML
<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Sfumato: motion blur and ambient occlusion on built-in scenes</title>
<style>
:root { color-scheme: light dark; --line: #8886; --soft: #8882; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.6rem; line-height: 1.2; } h2 { margin-top: 2.5rem; border-top: 1px solid var(--line); padding-top: 1rem; }
img { display: block; width: 100%; height: auto; background: var(--soft); }
.slider { position: relative; --cut: 50%; user-select: none; max-width: 960px; }
.slider .over { position: absolute; inset: 0; clip-path: inset(0 calc(100% - var(--cut)) 0 0); }
.slider .bar { position: absolute; top: 0; bottom: 0; left: var(--cut); width: 2px; margin-left: -1px; background: #fff; box-shadow: 0 0 3px #000; }
.slider input { position: absolute; inset: 0; width: 100%; height: 100%; margin: 0; opacity: 0; cursor: ew-resize; touch-action: pan-y; }
.slider:focus-within { outline: 2px solid Highlight; outline-offset: 2px; }
.choice { display: flex; justify-content: space-between; gap: 1rem; max-width: 960px; margin-bottom: .4rem; }
.choice select { font: inherit; max-width: 48%; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 18rem), 1fr)); gap: 1rem; margin-top: 1.5rem; }
figure { margin: 0; border: 1px solid var(--line); border-radius: 6px; overflow: hidden; }
figcaption { padding: .5rem .7rem .7rem; } figcaption span { display: block; font-variant-numeric: tabular-nums; }
code { font-size: .85em; }
figcaption code, code.command { display: block; margin-top: .4rem; font-size: .78rem; line-height: 1.4; overflow-wrap: anywhere; opacity: .8; }
table { margin: 1rem 0; border-collapse: collapse; font-variant-numeric: tabular-nums; display: block; overflow-x: auto; }
th, td { border: 1px solid var(--line); padding: .3rem .6rem; text-align: right; white-space: nowrap; } th:first-child, td:first-child { text-align: left; }
</style></head><body>
<h1>Sfumato: motion blur and ambient occlusion on built-in scenes</h1>
<p>Pictures of ${size/x/×} pixels, computed on <b>$device</b>. <a href="#occlusion">Ambient occlusion</a> comes last.
<i>Before</i> is the sharp frame; <i>truth</i> is the mean of
sharp frames rendered at moments spread over the shutter, which is open for half of the frame. The presets see the sharp
frame, its depth and its velocity, nothing else. <code>current-gen</code> and <code>dx11</code> are those of the SIGGRAPH
2012 course; their longest blur is short (radius 1/72 and 1/60 of the image height). <code>high</code> goes up to 6 %.</p>
<p>Figures are peak signal-to-noise ratios against truth over all pixels, over those that motion reaches, and over the
rest, as <code>sfumato compare</code> measures them.</p>
HTML
}

# Scene, the choice on the left and on the right at first, all choices.
slider() {
  local scene=$1 left=$2 right=$3 name options=""
  shift 3
  for name in "$@"; do options+="<option>$name</option>"; done
  cat <<HTML
<div class="compare" data-scene="$scene" data-left="$left" data-right="$right" hidden>
<div class="choice"><select aria-label="left picture">$options</select><select aria-label="right picture">$options</select></div>
<div class="slider"><img class="under" alt="right picture"><img class="over" alt="left picture"><div class="bar"></div>
<input type="range" min="0" max="100" step="0.1" value="50" aria-label="share of the left picture"></div></div>
HTML
}

script() {
  cat <<'HTML'
<script>
for (const box of document.querySelectorAll('.compare')) {
  const [left, right] = box.querySelectorAll('select');
  const slider = box.querySelector('.slider'), range = box.querySelector('input');
  const source = name => document.getElementById(box.dataset.scene + '-' + name).src;
  const show = () => {
    box.querySelector('.over').src = source(left.value);
    box.querySelector('.under').src = source(right.value);
  };
  left.value = box.dataset.left;
  right.value = box.dataset.right;
  left.onchange = right.onchange = show;
  range.oninput = () => slider.style.setProperty('--cut', range.value + '%');
  show();
  box.hidden = false;
}
</script>
</body></html>
HTML
}

section() {
  local scene=$1 subframes=$2 text=$3 name measured rows=""
  local base=$folder/$scene
  printf '<h2>%s</h2>\n<p>%s</p>\n' "$scene" "$text"
  slider "$scene" before high before "${presets[@]}" truth
  local figures=$folder/.figures
  {
    run "$sfumato" render "$scene" -o "$base-before.png" --size $size --samples 2
    local before_command=$command
    run "$sfumato" render "$scene" -o "$base-truth.png" --size $size --samples 2 --truth "$subframes"
    local truth_command=$command
    run "$sfumato" render "$scene" -o "$base.exr" --size $size --samples 2
    local frame_command=$command
    measured=$(decibels "$base-before.png" "$base-truth.png" "$base.exr")
    rows+="<tr><td>before<td>${measured// \/ /<td>}"
    command=$before_command picture "$scene" before before "$base-before.png" "$measured"
    for name in "${presets[@]}"; do
      run "$sfumato" apply motion-blur "$base.exr" -o "$base-$name.png" --preset "$name"
      measured=$(decibels "$base-$name.png" "$base-truth.png" "$base.exr")
      rows+="<tr><td>$name<td>${measured// \/ /<td>}"
      picture "$scene" "$name" "$name" "$base-$name.png" "$measured"
    done
    command=$truth_command picture "$scene" truth "truth, $subframes sub-frames" "$base-truth.png"
    for name in "${views[@]}"; do
      run "$sfumato" apply motion-blur "$base.exr" -o "$base-$name.png" --preset high \
        --set "motion-blur.debug_view=$name"
      picture "$scene" "$name" "debug view: $name" "$base-$name.png"
    done
  } >"$figures"
  printf '<table><tr><th>PSNR<th>all<th>moving<th>still%s</table>\n' "${rows// dB/}"
  printf '<p>All blurred pictures start from one frame with depth and velocity:<code class="command">%s</code></p>\n' \
    "$(printf '%s' "$frame_command" | escape)"
  printf '<div class="pictures">\n'
  cat "$figures"
  printf '</div>\n'
  rm -f "$figures"
}

# Visibility and what it does to a picture. Histories see the eight frames before.
occlusion_section() {
  local scene=$occlusion_scene name measured rows=""
  local base=$folder/occlusion-$scene
  local render=("$sfumato" render "$scene" --size $size)
  cat <<HTML
<h2 id="occlusion">$scene: ambient occlusion</h2>
<p>How much of the sky each visible point sees, white being all of it, and the picture with its ambient light scaled by
that. <i>Truth</i> is traced with rays. The effect sees the frame's depth and normals, nothing else. Figures are root mean
square errors of visibility; each preset is held against the truth with its own falloff and radius.</p>
HTML
  slider "occlusion-$scene" off on off on
  slider "occlusion-$scene" high truth "${occlusion_presets[@]}" truth
  local figures=$folder/.figures
  {
    run "${render[@]}" -o "$base-off.png"
    picture "occlusion-$scene" off "without occlusion" "$base-off.png"
    run "${render[@]}" -o "$base-on.png" --effects ambient-occlusion --preset high --set application=ambient
    picture "occlusion-$scene" on "ambient light occluded, preset high" "$base-on.png"
    for name in "${occlusion_presets[@]}"; do
      local effect=(--samples 1 --effects ambient-occlusion --preset "$name")
      [ "$name" != soma ] || effect+=(--preroll 8)
      run "${render[@]}" -o "$base-$name.exr" "${effect[@]}" --truth ambient-occlusion --truth-rays 32
      measured=$("$sfumato" compare "$base-$name.exr" "$base-$name.exr" --channel AO --reference-channel truth.AO |
        sed -n 's/^all .*RMSE *\([0-9.]*\) .*/\1/p')
      rows+="<tr><td>$name<td>$measured"
      run "${render[@]}" -o "$base-$name.png" "${effect[@]}"
      picture "occlusion-$scene" "$name" "$name" "$base-$name.png" "RMSE $measured"
    done
    run "${render[@]}" -o "$base-truth.png" --truth ambient-occlusion --truth-rays 64
    picture "occlusion-$scene" truth "truth, 64 rays" "$base-truth.png"
  } >"$figures"
  printf '<table><tr><th>preset<th>RMSE%s</table>\n<div class="pictures">\n' "$rows"
  cat "$figures"
  printf '</div>\n'
  rm -f "$figures"
}

mkdir -p $folder
# The device that is used, which need not be the first of the list.
used=$("$sfumato" render still -o $folder/device.png --size 16x16 -v 2>&1 | sed -n 's/^device: //p')
rm -f $folder/device.png
[ -n "$used" ] || fail "no Vulkan device can be used: $sfumato list devices tells why"
device=$("$sfumato" list devices | grep -F -m 1 -- "  $used  (" | sed 's/^[0-9]*  //' | escape) || device=$(escape <<<"$used")
echo "Device: $device"
{
  head_of_page
  for entry in "${scenes[@]}"; do
    IFS='|' read -r scene subframes text <<<"$entry"
    echo "$scene: sharp frame, truth of $subframes sub-frames, ${#presets[@]} presets, ${#views[@]} debug views" >&2
    section "$scene" "$subframes" "$text"
  done
  printf '<p>Colours of the debug views: velocity and neighbour maximum show direction as hue and length, against the longest
blur, as brightness; tile class shows still tiles blue, tiles of one even motion green, all others red.</p>\n'
  echo "$occlusion_scene: ambient occlusion off and on, ${#occlusion_presets[@]} presets, truth" >&2
  occlusion_section
  script
} >"$page.part"
mv "$page.part" "$page"
echo "$(pwd)/$page"
if [ -n "${DISPLAY:-}" ] && [ -t 1 ] && type -P xdg-open >/dev/null; then xdg-open "$page" >/dev/null 2>&1 || true; fi
