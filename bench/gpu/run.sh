#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Tests and benchmarks the CUDA build on a GPU. Uses no network and does not change the GPU's settings.
#
#   bench/gpu/run.sh [BUILD]      BUILD: a build folder of the preset cuda; it is built first if it has no programs.
#                                 Default: build/cuda, or the folder of this script if bench/gpu/pack.sh made it
#   bench/gpu/run.sh --list       lists the steps with their time limits in seconds
#
# The limits add up to at most 540 s, including the grace period of timeout(1). After each step, three files in $OUT
# (default gpu_results) are updated: summary.json, table.txt and logs.tar.gz. Exit status: 0 if all steps passed, 1 if
# one failed, 2 if there is nothing to run. No GPU is a failure unless VESTA_REQUIRE_CUDA=0. GAUSSIANS, PIXELS and VIEWS
# change the workload of gpu_kernels.
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
build=$root/build/cuda
if [[ -x $here/bench/gpu_kernels ]]; then build=$here; fi
build=${1:-$build}
out=${OUT:-gpu_results}
export VESTA_REQUIRE_CUDA=${VESTA_REQUIRE_CUDA:-1}
export PATH=$PATH:/usr/local/cuda/bin
# Seconds from a step's limit to its SIGKILL.
grace=1

kernels=$build/bench/gpu_kernels
workload=(--gaussians "${GAUSSIANS:-1000000}" --pixels "${PIXELS:-1000000}" --views "${VIEWS:-100}")
# each FUNCTION: calls FUNCTION with the name, limit in seconds and command of every step, most important first.
each() {
  "$1" gpu 15 "$kernels" --probe yes
  "$1" sanitizer 20 compute-sanitizer --tool memcheck --error-exitcode 9 "$kernels" --probe yes
  "$1" device_math 15 "$build/tests/device_math_test"
  "$1" backend 20 "$build/tests/cuda_backend_test"
  "$1" engine 20 "$build/tests/cuda_engine_test"
  "$1" splat 16 "$build/tests/cuda_splat_test"
  "$1" training 30 "$build/tests/cuda_training_test"
  "$1" gpu_kernels 150 "$kernels" "${workload[@]}" --json "$work/gpu_kernels.json"
  local tool
  # Without the training test, which launches the same kernels but takes minutes under these tools.
  for tool in memcheck racecheck synccheck; do
    "$1" "$tool.splat" 60 compute-sanitizer --tool "$tool" --error-exitcode 9 "$build/tests/cuda_splat_test"
    "$1" "$tool.backend" 20 compute-sanitizer --tool "$tool" --error-exitcode 9 "$build/tests/cuda_backend_test"
  done
}

list() { printf '%-18s %4d\n' "$1" "$2"; }
if [[ $build == --list ]]; then
  work=.
  each list
  exit
fi

if [[ ! -x $kernels ]]; then
  if ! command -v nvcc >/dev/null || [[ ! -f $root/CMakePresets.json ]]; then
    echo "run.sh: $build has no binaries and there is no nvcc to build them; see bench/gpu/pack.sh" >&2
    exit 2
  fi
  cmake -S "$root" --preset cuda -DVESTA_BUILD_APPS=OFF || exit 2
  cmake --build "$root/build/cuda" --parallel --target tests_cuda gpu_kernels || exit 2
  build=$root/build/cuda kernels=$root/build/cuda/bench/gpu_kernels
fi

mkdir -p "$out" || exit 2
work=$(mktemp -d) || exit 2
mkdir "$work/logs"
trap 'rm -rf "$work"' EXIT

rows=() failed=0 gpu="not known" has_gpu=1 has_sanitizer=1

# quote TEXT: sets $quoted to the text as a JSON string.
quote() {
  quoted=${1//\\/\\\\}
  quoted=\"${quoted//\"/\\\"}\"
  quoted=${quoted//[[:cntrl:]]/ }
}

table() {
  printf 'gpu: %s\n\n%-18s %-40s %s\n' "$gpu" step result seconds
  local row name verdict seconds
  for row in "${rows[@]}"; do
    IFS='|' read -r name seconds verdict <<<"$row"
    printf '%-18s %-40s %7d\n' "$name" "$verdict" "$seconds"
  done
  if [[ -f $work/logs/gpu_kernels.log ]]; then printf '\n%s\n' "$(<"$work/logs/gpu_kernels.log")"; fi
}

json() {
  local row name verdict seconds separator="" passed=true quoted
  if ((failed)); then passed=false; fi
  quote "$gpu"
  printf '{"bench": "gpu", "gpu": %s, "passed": %s, "rows": [' "$quoted" $passed
  for row in "${rows[@]}"; do
    IFS='|' read -r name seconds verdict <<<"$row"
    quote "$verdict"
    printf '%s\n  {"step": "%s", "result": %s, "seconds": %d}' "$separator" "$name" "$quoted" "$seconds"
    separator=,
  done
  local kernels=null
  if [[ -s $work/gpu_kernels.json ]]; then kernels=$(<"$work/gpu_kernels.json"); fi
  printf '],\n "gpu_kernels": %s}\n' "$kernels"
}

# Replaces each file atomically.
write_results() {
  table >"$out/.part" && mv -f "$out/.part" "$out/table.txt"
  json >"$out/.part" && mv -f "$out/.part" "$out/summary.json"
  tar -C "$work" -czf "$out/.part" logs && mv -f "$out/.part" "$out/logs.tar.gz"
}

# note NAME SECONDS VERDICT
note() {
  rows+=("$1|$2|$3")
  printf '%-18s %-40s %4d s\n' "$1" "$3" "$2"
}

# step NAME LIMIT COMMAND...: runs the command with its own log, and records the result.
step() {
  local name=$1 limit=$2 begin=$SECONDS status=0 verdict log=$work/logs/$1.log
  shift 2
  if [[ $has_gpu == 0 ]]; then
    note "$name" 0 "skipped: no GPU"
    return
  fi
  if [[ $1 == compute-sanitizer && $has_sanitizer == 0 ]]; then
    note "$name" 0 "skipped: no compute-sanitizer that works"
    return
  fi
  timeout -k "$grace" "$limit" "$@" >"$log" 2>&1 || status=$?
  case $status in
    0) verdict=passed ;;
    124 | 137) verdict="stopped after $limit s" ;;
    *) verdict="FAILED ($status)" ;;
  esac
  case $name in
    gpu)
      IFS= read -r gpu <"$log"
      if ((status != 0)); then
        has_gpu=0 gpu="none: $gpu"
        verdict="no GPU, and one was required"
        if [[ $VESTA_REQUIRE_CUDA == 0 ]]; then verdict="no GPU" status=0; fi
      fi
      ;;
    sanitizer)
      # The tool may exist but not work. Its final summary shows that it worked.
      if ((status != 0)) || ! grep -q 'ERROR SUMMARY: 0 errors' "$log"; then
        has_sanitizer=0 verdict="does not work here ($status)" status=0
      fi
      ;;
  esac
  ((status == 0)) || failed=1
  note "$name" $((SECONDS - begin)) "$verdict"
  write_results
}

each step
write_results  # with the steps that were skipped
echo
table
exit $failed
