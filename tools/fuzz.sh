#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Fuzzes each target for SECONDS, AT_A_TIME targets in parallel (docs/fuzzing.md). Fails if one finds an error. Inputs
# that fail or reach new code are saved in OUT.
#   tools/fuzz.sh SECONDS [AT_A_TIME [OUT [TARGET ...]]]     needs build/fuzz/fuzz; default OUT: build/fuzz/found
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

seconds=${1:?"usage: tools/fuzz.sh SECONDS [AT_A_TIME [OUT [TARGET ...]]]"}
at_a_time=${2:-2}
out=${3:-build/fuzz/found}
targets=("${@:4}")
if ((${#targets[@]} == 0)); then
  for folder in tests/fuzz/corpus/*/; do targets+=("$(basename "$folder")"); done
fi

# In memory if possible, because each run writes files.
scratch=$(mktemp -d "$([[ -w /dev/shm ]] && echo /dev/shm || echo "${TMPDIR:-/tmp}")/vesta_fuzz.XXXXXX")
trap 'rm -rf "$scratch"' EXIT

fuzz_one() {
  local name=$1
  mkdir -p "$out/$name"
  # The undefined-behaviour sanitizer checks only the baseline kernels.
  local status=0
  TMPDIR=$scratch VESTA_SIMD=sse2 UBSAN_OPTIONS=print_stacktrace=1 \
    "build/fuzz/fuzz/$name" -max_total_time="$seconds" -max_len=4096 -timeout=20 -rss_limit_mb=1024 \
    -malloc_limit_mb=512 -print_final_stats=1 -artifact_prefix="$out/$name-" "$out/$name" "tests/fuzz/corpus/$name" \
    >"$out/$name.log" 2>&1 || status=$?
  local runs
  runs=$(sed -n 's/stat::number_of_executed_units: *//p' "$out/$name.log")
  if ((status != 0)); then
    echo "$name: FOUND an error after ${runs:-?} runs:"
    grep -E 'what\(\)|ERROR|runtime error|SUMMARY|Test unit written' "$out/$name.log" | sed 's/^/  /'
    return 1
  fi
  echo "$name: $runs runs in $seconds s, $(grep -oE 'cov: [0-9]+' "$out/$name.log" | tail -1), no error"
}

failed=0
running=0
for name in "${targets[@]}"; do
  if ((running == at_a_time)); then
    wait -n || failed=1
    running=$((running - 1))
  fi
  fuzz_one "$name" &
  running=$((running + 1))
done
while ((running > 0)); do
  wait -n || failed=1
  running=$((running - 1))
done
exit "$failed"
