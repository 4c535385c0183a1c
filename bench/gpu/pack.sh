#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Copies bench/gpu/run.sh, its programs and their shared libraries into a folder for another machine:
#   bench/gpu/pack.sh build/cuda FOLDER     then run on that machine: FOLDER/run.sh
# The programs find the libraries relative to themselves ($ORIGIN/../lib, cmake/Cuda.cmake), so the folder can be moved.
# They use the C library and dynamic loader of the other machine.
set -euo pipefail
build=${1:?usage: pack.sh BUILD FOLDER} folder=${2:?usage: pack.sh BUILD FOLDER}
mkdir -p "$folder"/{tests,bench,lib}
cp "$build"/tests/{device_math,cuda_backend,cuda_engine,cuda_splat,cuda_training}_test "$folder/tests"
cp "$build/bench/gpu_kernels" "$folder/bench"
cp "$(dirname "${BASH_SOURCE[0]}")/run.sh" "$folder"
ldd "$build"/tests/{device_math,cuda_backend,cuda_engine,cuda_splat,cuda_training}_test "$build/bench/gpu_kernels" |
  awk '/=> \// && $3 !~ /\/(libc|libm|libdl|librt|libpthread|ld-linux[^\/]*|libcuda)\.so/ {print $3}' | sort -u |
  xargs -r -I{} cp -L {} "$folder/lib"
du -sh "$folder"
