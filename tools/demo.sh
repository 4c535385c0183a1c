#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs the demo: makes a small scene, trains it, renders its test views and plots the convergence.
#   tools/demo.sh BUILD_DIR OUT_DIR
set -eu

# About a minute and a half on two cores, with both stages.
train_flags="--iterations=2500 --lm_iterations=10"

[ $# -eq 2 ] || { echo "usage: tools/demo.sh BUILD_DIR OUT_DIR" >&2; exit 2; }
build_dir=$1
out_dir=$2
tools_dir=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
for program in vesta vesta_demo_scene; do
  [ -x "$build_dir/$program" ] || { echo "demo.sh: $build_dir/$program is missing; ./run demo builds it" >&2; exit 1; }
done

# Debian's Python has Debian's matplotlib; PATH may have another Python first.
python=/usr/bin/python3
[ -x "$python" ] || python=python3
MPLCONFIGDIR=$(mktemp -d)
export MPLCONFIGDIR PYTHONDONTWRITEBYTECODE=1
trap 'rm -rf -- "$MPLCONFIGDIR"' EXIT

step() { printf '\n-- %s\n' "$*"; }

scene=$out_dir/scene model=$out_dir/model renders=$out_dir/renders
mkdir -p -- "$out_dir"

step "Making the scene"
"$build_dir/vesta_demo_scene" --out "$scene"

step "Training"
# shellcheck disable=SC2086  # word splitting is intended
"$build_dir/vesta" train "$scene" --out "$model" $train_flags

step "Rendering the test views"
"$build_dir/vesta" render "$model/point_cloud.ply" "$scene" --out "$renders" --truth

step "Result: figures at the end of each stage, on the test views unless stated"
"$python" "$tools_dir/history_table.py" "$model/metrics.json"
"$python" "$tools_dir/plot_history.py" "$model/metrics.json" "$out_dir/convergence.png"
"$python" "$tools_dir/contact_sheet.py" "$out_dir/renders.png" "$renders"/*.png

cat <<TEXT

  splat, for any splat viewer          $model/point_cloud.ply
  all figures, with the history        $model/metrics.json
  loss and PSNR over time              $out_dir/convergence.png
  test views, render left, truth right $out_dir/renders.png
                                       (single images in $renders)
TEXT
