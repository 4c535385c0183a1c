#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Gathers what bench/gpu/run.sh needs of a CUDA build, with its shared libraries, for a machine without them:
#   bench/gpu/pack.sh build/cuda FOLDER     then there: FOLDER/run.sh
# The programs find the libraries beside them ($ORIGIN/../lib, cmake/Cuda.cmake), wherever the folder lies. The C library
# and its loader are that machine's own.
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
