#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs the steps of docs/guide/from_a_film.md on a film by the demo's ray tracer. Takes some minutes.
#   tools/tutorial.sh BUILD_DIR OUT_DIR [--quick] [--given_cameras]
#     --quick          fewer training iterations
#     --given_cameras  without film and COLMAP: fewer and smaller images, with the cameras of the ray tracer
# Needs colmap and, for the films, ffmpeg (Debian packages colmap and ffmpeg). OUT_DIR must not contain results of
# another run.
set -eu

usage() { echo "usage: tools/tutorial.sh BUILD_DIR OUT_DIR [--quick] [--given_cameras]" >&2; exit 2; }
fail() { echo "tutorial.sh: $*" >&2; exit 1; }

[ $# -ge 2 ] || usage
build_dir=$1
out_dir=$2
shift 2
# Small images, and a lens like a phone's that distorts by some pixels at the corners.
frames=48 width=320 height=240 lens=-0.12,0.02,0.001,-0.001
train_flags= find_cameras=yes
for flag in "$@"; do
  case $flag in
    --quick) train_flags=--iterations=600 ;;
    --given_cameras) find_cameras= frames=20 width=160 height=120 ;;
    *) echo "tutorial.sh: unknown flag $flag" >&2; usage ;;
  esac
done

for program in vesta vesta_demo_scene; do
  [ -x "$build_dir/$program" ] || fail "$build_dir/$program is missing; ./run build builds it"
done
has() { command -v "$1" >/dev/null 2>&1; }
if [ -n "$find_cameras" ] && ! has colmap; then
  fail "colmap, which finds the camera of each image, is missing; install Debian's package colmap"
fi
films=yes
has ffmpeg || { films=; echo "No ffmpeg (Debian's package ffmpeg): the images are used directly, and no film is made."; }

started=$(date +%s)
step() { printf '\n-- %s   (after %d s)\n' "$*" "$(($(date +%s) - started))"; }
# say_and COMMAND...: prints and runs a command. quietly LOG COMMAND...: the same, with the output in a log, whose end
# is printed on failure.
say_and() { echo "   $*"; "$@"; }
quietly() {
  log=$1
  shift
  echo "   $*"
  "$@" >"$log" 2>&1 || { tail -n 20 "$log" >&2; fail "$1 failed; its output is in $log"; }
}

take=$out_dir/take scene=$out_dir/scene logs=$out_dir/logs result=$out_dir/result
[ ! -e "$scene" ] || fail "$scene exists; give an OUT_DIR without results of another run"
mkdir -p -- "$logs"

step "Filming: $frames images along a walk around the demo's scene"
say_and "$build_dir/vesta_demo_scene" "--out=$take" "--views=$frames" "--width=$width" "--height=$height" --walk "--lens=$lens"

if [ -z "$find_cameras" ]; then
  mv -- "$take" "$scene"
else
  photographs=$take/images how_many=
  if [ -n "$films" ]; then
    photographs=$out_dir/film.mp4 how_many=--frames=$frames
    quietly "$logs/film.log" ffmpeg -y -framerate 10 -i "$take/images/view_%04d.png" -crf 12 -pix_fmt yuv420p "$photographs"
  fi
  step "Finding the cameras with COLMAP"
  # shellcheck disable=SC2086  # zero or one flag
  say_and "$build_dir/vesta" reconstruct "$photographs" "--out=$scene" $how_many
fi

step "Checking the scene"
say_and "$build_dir/vesta" doctor "$scene"

step "Training"
# shellcheck disable=SC2086  # zero or one flag
say_and "$build_dir/vesta" train "$scene" "--out=$result" $train_flags

if [ -n "$films" ]; then
  step "Rendering a film of the splat"
  say_and "$build_dir/vesta" render "$result/point_cloud.ply" "$scene" "--out=$out_dir/orbit" --path=orbit --frames=60 \
    "--film=$out_dir/orbit.mp4"
fi

step "Done"
cat <<TEXT

  report: quality and errors        $result/report.html
  splat, for any splat viewer       $result/point_cloud.ply
TEXT
[ -z "$films" ] || echo "  film of the splat                 $out_dir/orbit.mp4"
