#!/usr/bin/env bash
# Proves and measures the CUDA build on a machine with a GPU; no network is used. Under ten minutes.
#
#   bench/gpu/run.sh [BUILD]      BUILD: a tree of the preset cuda (default build/cuda), or a folder that
#                                 bench/gpu/pack.sh made of one elsewhere, its shared libraries beside it in lib/
#
# Runs the tests of the label cuda, compute-sanitizer's memcheck and racecheck over a short training, and the kernel
# table at 100 views of a megapixel and a million Gaussians (GAUSSIANS, PIXELS, VIEWS change that). Prints one table;
# JSON and logs go to $OUT (default gpu_results). Builds first where BUILD has no binaries and there is an nvcc.
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=${1:-$root/build/cuda}
out=${OUT:-gpu_results}
mkdir -p "$out"
export LD_LIBRARY_PATH=$build/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH} VESTA_REQUIRE_CUDA=1
export PATH=$PATH:/usr/local/cuda/bin

if [[ ! -x $build/bench/gpu_kernels ]]; then
  if ! command -v nvcc >/dev/null || [[ ! -f $root/CMakePresets.json ]]; then
    echo "run.sh: $build has no binaries and there is no nvcc to build them; see bench/gpu/pack.sh" >&2
    exit 2
  fi
  cmake -S "$root" --preset cuda -DVESTA_BUILD_APPS=OFF || exit 2
  cmake --build "$root/build/cuda" --parallel --target tests_cuda gpu_kernels || exit 2
  build=$root/build/cuda
fi

nvidia-smi --query-gpu=name,driver_version,memory.total --format=csv,noheader | tee "$out/gpu.txt"

rows=() failed=0
# step NAME LIMIT_S COMMAND...: runs it, its output in a log of its own, and notes how it went.
step() {
  local name=$1 limit=$2 begin=$SECONDS status=0 verdict
  shift 2
  timeout "$limit" "$@" >"$out/$name.log" 2>&1 || status=$?
  case $status in
    0) verdict=passed ;;
    124) verdict="stopped after $limit s" ;;
    *) verdict="FAILED ($status)" ;;
  esac
  ((status == 0)) || failed=1
  rows+=("$name|$verdict|$((SECONDS - begin))")
  printf '%-28s %-24s %4d s\n' "$name" "$verdict" $((SECONDS - begin))
}

for test in device_math_test cuda_backend_test cuda_engine_test cuda_splat_test; do
  step "$test" 120 "$build/tests/$test" --gtest_output="json:$out/$test.json"
done

training=(--gtest_filter=CudaTraining.RunsAreTheSameToTheBit:CudaSplatProblem.*:CudaView.*)
if command -v compute-sanitizer >/dev/null; then
  step memcheck 120 compute-sanitizer --tool memcheck --error-exitcode 9 "$build/tests/cuda_splat_test" "${training[@]}"
  step racecheck 150 compute-sanitizer --tool racecheck --error-exitcode 9 "$build/tests/cuda_splat_test" \
    --gtest_filter=CudaView.*:CudaLoss.*
else
  rows+=("memcheck, racecheck|skipped: no compute-sanitizer|0")
fi

step gpu_kernels 240 "$build/bench/gpu_kernels" --gaussians "${GAUSSIANS:-1000000}" --pixels "${PIXELS:-1000000}" \
  --views "${VIEWS:-100}" --json "$out/gpu_kernels.json"

echo
cat "$out/gpu_kernels.log"
echo
printf '%-28s %-24s %s\n' step result seconds
{
  printf '{"bench": "gpu", "gpu": "%s", "rows": [' "$(head -1 "$out/gpu.txt")"
  separator=""
  for row in "${rows[@]}"; do
    IFS='|' read -r name verdict seconds <<<"$row"
    printf '%-28s %-24s %s\n' "$name" "$verdict" "$seconds" >&2
    printf '%s{"step": "%s", "result": "%s", "seconds": %s}' "$separator" "$name" "$verdict" "$seconds"
    separator=", "
  done
  echo ']}'
} 2>&1 >"$out/summary.json"
exit $failed
