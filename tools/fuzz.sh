#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Fuzzes each target for some seconds, so many at a time: docs/fuzzing.md. Fails where one finds something; the input
# then lies in OUT, as do those that reached new code.
#   tools/fuzz.sh SECONDS [AT_A_TIME [OUT [TARGET ...]]]     needs build/fuzz/fuzz; OUT: build/fuzz/found by default
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

seconds=${1:?"usage: tools/fuzz.sh SECONDS [AT_A_TIME [OUT [TARGET ...]]]"}
at_a_time=${2:-2}
out=${3:-build/fuzz/found}
targets=("${@:4}")
if ((${#targets[@]} == 0)); then
  for folder in tests/fuzz/corpus/*/; do targets+=("$(basename "$folder")"); done
fi

# In memory where that is possible: each run writes files.
scratch=$(mktemp -d "$([[ -w /dev/shm ]] && echo /dev/shm || echo "${TMPDIR:-/tmp}")/vesta_fuzz.XXXXXX")
trap 'rm -rf "$scratch"' EXIT

fuzz_one() {
  local name=$1
  mkdir -p "$out/$name"
  # The baseline kernels: the undefined-behaviour sanitizer checks those alone.
  local status=0
  TMPDIR=$scratch VESTA_SIMD=sse2 UBSAN_OPTIONS=print_stacktrace=1 \
    "build/fuzz/fuzz/$name" -max_total_time="$seconds" -max_len=4096 -timeout=20 -rss_limit_mb=1024 \
    -malloc_limit_mb=512 -print_final_stats=1 -artifact_prefix="$out/$name-" "$out/$name" "tests/fuzz/corpus/$name" \
    >"$out/$name.log" 2>&1 || status=$?
  local runs
  runs=$(sed -n 's/stat::number_of_executed_units: *//p' "$out/$name.log")
  if ((status != 0)); then
    echo "$name: FOUND something after ${runs:-?} runs:"
    grep -E 'what\(\)|ERROR|runtime error|SUMMARY|Test unit written' "$out/$name.log" | sed 's/^/  /'
    return 1
  fi
  echo "$name: $runs runs in $seconds s, $(grep -oE 'cov: [0-9]+' "$out/$name.log" | tail -1), nothing found"
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
