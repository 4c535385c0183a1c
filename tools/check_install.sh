#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Tests the installed package as a user would:   tools/check_install.sh BUILD_DIR WORK_DIR
# Builds and runs the examples against the installed package, and one with this source tree as a subdirectory.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
root=$PWD
build_dir=$1
mkdir -p "$2"
work=$(cd "$2" && pwd)
jobs=${JOBS:-$(nproc)}
rm -rf "${work:?}"/*
launcher=()
if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi

say() { printf -- '-- %s\n' "$*"; }
fail() {
  echo "check_install.sh: $*" >&2
  exit 1
}
# configure SOURCE_DIR BUILD_DIR ARGS... : logs to BUILD_DIR/configure.log.
configure() {
  local source=$1 build=$2
  shift 2
  mkdir -p "$build"
  cmake -S "$source" -B "$build" -G Ninja "${launcher[@]}" "-DCMAKE_PREFIX_PATH=$work/prefix" \
    "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Wpedantic -Wshadow -Werror" "$@" >"$build/configure.log" 2>&1
}

say "install, then move the result: the package must be relocatable"
cmake --install "$build_dir" --prefix "$work/first_place" >"$work/install.log"
mv "$work/first_place" "$work/prefix"
here=$(printf %s "$root" | sed 's/[][\.*^$+?(){}|]/\\&/g')
if grep -rlIE -e "(^|[^A-Za-z0-9_/}.-])$here([/\";]|\$)" -e first_place "$work/prefix"; then fail "the files above contain paths of the source or build folder"; fi
"$work/prefix/bin/vesta" help >/dev/null

say "all installed headers compile together in one source"
mkdir "$work/headers"
(cd "$work/prefix/include/vesta" && find . -name '*.h' | sort | sed 's|^./\(.*\)|#include "\1"|') >"$work/headers/all.cpp"
cat >"$work/headers/CMakeLists.txt" <<'TEXT'
cmake_minimum_required(VERSION 3.25)
project(headers LANGUAGES CXX)
find_package(vesta 0.2.0 CONFIG REQUIRED)
add_library(headers OBJECT all.cpp)
target_link_libraries(headers vesta::core vesta::solver vesta::toy vesta::bundle_adjustment
  vesta::pose_graph vesta::ceres_bridge vesta::ceres_functors)
TEXT
configure "$work/headers" "$work/headers/build" || { cat "$work/headers/build/configure.log"; fail "not configured"; }
cmake --build "$work/headers/build" | tail -n 1

say "unavailable versions and components are refused"
for request in "0.3 CONFIG REQUIRED" "0.2 CONFIG REQUIRED COMPONENTS unheard_of"; do
  mkdir -p "$work/refused"
  printf 'cmake_minimum_required(VERSION 3.25)\nproject(refused LANGUAGES CXX)\nfind_package(vesta %s)\n' "$request" \
    >"$work/refused/CMakeLists.txt"
  if configure "$work/refused" "$work/refused/build"; then fail "find_package(vesta $request) succeeded"; fi
done
grep -q "vesta has no component unheard_of; there are: core" "$work/refused/build/configure.log" ||
  { cat "$work/refused/build/configure.log"; fail "the message does not name the unknown component"; }

examples=(exponential_fit registration many_fits eigen_types slow_detector unknown_gains cameras_from_pairs
  ceres_examples from_ceres)
if [[ -e $work/prefix/include/vesta/kernels/mpi ]]; then examples+=(over_processes); fi
for example in "${examples[@]}"; do
  say "examples/$example"
  arguments=(-DCMAKE_BUILD_TYPE=Release)
  # Only the bridge needs Ceres.
  if [[ $example != from_ceres ]]; then arguments+=(-DCMAKE_DISABLE_FIND_PACKAGE_Ceres=ON); fi
  configure "examples/$example" "$work/$example" "${arguments[@]}" ||
    { cat "$work/$example/configure.log"; fail "examples/$example was not configured"; }
  cmake --build "$work/$example" | tail -n 1
  run=("$work/$example/$example")
  # A folder of several programs, which are its tests.
  if [[ ! -e ${run[0]} ]]; then run=(ctest --test-dir "$work/$example" --output-on-failure --no-tests=error); fi
  "${run[@]}" >"$work/$example/output.txt" ||
    { cat "$work/$example/output.txt"; fail "examples/$example does not reach the known answer"; }
  tail -n 2 "$work/$example/output.txt"
done
python3 tools/check_guide.py --report "$work/slow_detector/output.txt"

say "as a subdirectory"
mkdir "$work/subdirectory"
cat >"$work/subdirectory/CMakeLists.txt" <<TEXT
cmake_minimum_required(VERSION 3.25)
project(outer LANGUAGES CXX)
add_subdirectory($root vesta)
if(TARGET vesta OR TARGET vesta_gs OR BUILD_TESTING)
  message(FATAL_ERROR "as a subdirectory, vesta must define only libraries")
endif()
add_executable(fit $root/examples/exponential_fit/exponential_fit.cpp)
target_link_libraries(fit PRIVATE vesta::solver)
TEXT
configure "$work/subdirectory" "$work/subdirectory/build" -DVESTA_CERES_BRIDGE=OFF ||
  { cat "$work/subdirectory/build/configure.log"; fail "not configured"; }
cmake --build "$work/subdirectory/build" --parallel "$jobs" --target fit | tail -n 1
"$work/subdirectory/build/fit"
