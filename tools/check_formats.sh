#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Checks the compact splat formats (.spz, .splat, .compressed.ply, .sog) against other programs: spz-js and
# @playcanvas/splat-transform, which npm installs in FOLDER, and vesta read each other's files. Prints sizes, counts,
# errors of the means, and the PSNR on SCENE. Needs node, npm and a network. Not part of .ci/run.
#   tools/check_formats.sh VESTA SPLAT SCENE [FOLDER]        FOLDER: working folder; default: a temporary one
set -euo pipefail

vesta=$(realpath "${1:?"usage: tools/check_formats.sh VESTA SPLAT SCENE [FOLDER]"}")
splat=$(realpath "${2:?"SPLAT is missing"}")
scene=$(realpath "${3:?"SCENE is missing"}")
folder=${4:-$(mktemp -d)}
mkdir -p "$folder"
cd "$folder"

[[ -d node_modules/spz-js && -d node_modules/@playcanvas/splat-transform ]] ||
  npm install --silent --no-fund --no-audit --prefix . spz-js@1.2.5 @playcanvas/splat-transform@2.7.1

transform() { node node_modules/@playcanvas/splat-transform/bin/cli.mjs --quiet --overwrite "$@" >/dev/null; }

# spz-js does not change the frame. The frame of .spz is y up and z backward, which is the frame of .ply rotated by 180 degrees about x.
cat >spz_js.mjs <<'EOF'
import { createReadStream, readFileSync, writeFileSync } from 'fs';
import { Readable } from 'stream';
import { loadPly, loadSpz, loadCompressedPly, serializePly, serializeSpz, serializeCompressedPly } from 'spz-js';
const [from, to] = process.argv.slice(2);
const stream = () => Readable.toWeb(createReadStream(from));
const cloud = from.endsWith('.spz') ? await loadSpz(readFileSync(from))
  : from.endsWith('.compressed.ply') ? await loadCompressedPly(stream()) : await loadPly(stream());
const bytes = to.endsWith('.spz') ? await serializeSpz(cloud)
  : to.endsWith('.compressed.ply') ? serializeCompressedPly(cloud) : serializePly(cloud);
writeFileSync(to, Buffer.from(bytes));
EOF
spz_js() { node spz_js.mjs "$@"; }

# Compares two .ply files of floats: number of Gaussians, and the median and maximum distance from a mean of the first
# to the nearest mean of the second.
cat >means.mjs <<'EOF'
import { readFileSync } from 'fs';
const means = (path) => {
  const bytes = readFileSync(path), end = bytes.indexOf('end_header\n') + 11;
  const lines = bytes.subarray(0, end).toString('latin1').split('\n');
  const names = lines.filter((l) => l.startsWith('property float ')).map((l) => l.slice(15));
  const n = Number(lines.find((l) => l.startsWith('element vertex ')).slice(15));
  const at = ['x', 'y', 'z'].map((name) => names.indexOf(name));
  return Array.from({ length: n }, (_, i) => at.map((k) => bytes.readFloatLE(end + 4 * (i * names.length + k))));
};
const [a, b] = process.argv.slice(2, 4).map(means);
const side = 0.05, cells = new Map();
const key = (p, d = [0, 0, 0]) => p.map((x, k) => Math.floor(x / side) + d[k]).join(' ');
for (const p of b) cells.has(key(p)) ? cells.get(key(p)).push(p) : cells.set(key(p), [p]);
const near = (p) => {
  let best = Infinity;
  for (let d = 0; d < 27; ++d) {
    for (const q of cells.get(key(p, [d % 3 - 1, Math.floor(d / 3) % 3 - 1, Math.floor(d / 9) - 1])) ?? []) {
      best = Math.min(best, Math.max(...p.map((x, k) => Math.abs(x - q[k]))));
    }
  }
  return best < side ? best : Math.min(...b.map((q) => Math.max(...p.map((x, k) => Math.abs(x - q[k])))));
};
const far = a.map(near).sort((x, y) => x - y);
console.log(`${a.length} and ${b.length} Gaussians; errors of the means: ${far[a.length >> 1].toExponential(1)} median, ` +
  `${far[a.length - 1].toExponential(1)} maximum`);
EOF

background=$(sed -n 's/^comment vesta background \(.*\) \(.*\) \(.*\)$/\1,\2,\3/p;/^end_header/q' "$splat" | tr -d '\0')
# evaluate NAME FILE: prints size and PSNR on test and training views, with the background of SPLAT.
evaluate() {
  "$vesta" eval "$2" "$scene" --background="${background:-0,0,0}" |
    awk -v name="$1" -v bytes="$(stat -c %s "$2")" '/^test/ { test = $3 } /^train / { train = $3 }
      END { printf "%-64s%10d bytes  test %s dB  train %s dB\n", name, bytes, test, train }'
}

"$vesta" convert "$splat" --out=original.ply
evaluate "SPLAT" original.ply

echo "-- written by vesta"
for format in spz compressed.ply sog; do
  # spz-js does not read version 4.
  options=""
  [ "$format" = spz ] && options=--spz_version=2
  "$vesta" convert "$splat" --out="ours.$format" $options >/dev/null
  evaluate "ours.$format" "ours.$format"
  transform "ours.$format" "transform_$format.ply"
  evaluate "ours.$format, to .ply by splat-transform" "transform_$format.ply"
  node means.mjs original.ply "transform_$format.ply"
  [[ $format == sog ]] && continue  # spz-js does not read it
  spz_js "ours.$format" "spz_js_$format.ply"
  if [[ $format == spz ]]; then transform "spz_js_$format.ply" --rotate 180,0,0 "spz_js_$format.ply"; fi
  evaluate "ours.$format, to .ply by spz-js" "spz_js_$format.ply"
  node means.mjs original.ply "spz_js_$format.ply"
done

for format in v4.spz splat; do
  "$vesta" convert "$splat" --out="ours.$format" >/dev/null
  evaluate "ours.$format" "ours.$format"
  transform "ours.$format" "transform_$format.ply"
  evaluate "ours.$format, to .ply by splat-transform" "transform_$format.ply"
  node means.mjs original.ply "transform_$format.ply"
done

echo "-- read by vesta"
# spz-js does not change the frame.
transform original.ply --rotate 180,0,0 turned.ply
spz_js turned.ply spz_js.spz
spz_js original.ply spz_js.compressed.ply
transform original.ply --spz-version 3 transform.spz
transform original.ply transform.v4.spz
transform original.ply transform.compressed.ply
transform -g cpu original.ply transform.sog
for file in spz_js.spz spz_js.compressed.ply transform.spz transform.v4.spz transform.compressed.ply transform.sog; do
  evaluate "$file" "$file"
  "$vesta" convert "$file" --out=read.ply >/dev/null
  node means.mjs original.ply read.ply
done

echo "-- for comparison: each of the other programs reads the other's file"
transform transform.spz by_transform.ply
evaluate "transform.spz, to .ply by splat-transform" by_transform.ply
spz_js transform.compressed.ply by_spz_js.ply
evaluate "transform.compressed.ply, to .ply by spz-js" by_spz_js.ply
