#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds and tests vesta on other systems than CI's, in a root folder with Debian 13. debootstrap makes this folder at
# the first run (build/systems/debian13, 4 GiB); later runs reuse it. Needs root, the network and debootstrap.
#   tools/systems.sh [gcc] [shared] [clang] [arm64]      default: all
# gcc: ./run demo and ./run test. shared: installs shared libraries, and runs an example with them. clang: build with
# warnings as errors, and all tests. arm64: cross build, and the unit tests of kernels, solver and problems under qemu.
# VESTA_DEBIAN_MIRROR: the mirror; default: the first of this system's apt sources.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

root=$PWD/build/systems/debian13
jobs=${JOBS:-$(nproc)}

fail() {
  echo "systems.sh: $1" >&2
  exit 1
}

[[ $(id -u) == 0 ]] || fail "needs root; run it with sudo"
command -v debootstrap >/dev/null || fail "needs debootstrap; install the package debootstrap"

# A mirror of this system, or Debian's own.
mirror() {
  grep -rhoE '(^deb |^URIs:) *\S+/debian/?( |$)' /etc/apt/sources.list /etc/apt/sources.list.d 2>/dev/null |
    grep -oE 'https?://\S+' | head -n 1 || echo https://deb.debian.org/debian
}

in_root() {
  chroot "$root" /usr/bin/env -i HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive JOBS="$jobs" \
    PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
    ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} "$@"
}

packages() { in_root apt-get install -q -y --no-install-recommends "$@" >"$root/tmp/apt.log" || fail "see $root/tmp/apt.log"; }

make_root() {
  if [[ ! -e $root/made ]]; then
    rm -rf "$root"
    mkdir -p "$root"
    debootstrap --variant=minbase --include=ca-certificates trixie "$root" "${VESTA_DEBIAN_MIRROR:-$(mirror)}" \
      >"$root.log" || fail "debootstrap failed; see $root.log"
    touch "$root/made"
  fi
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  mountpoint -q "$root/proc" || mount -t proc proc "$root/proc"
  mountpoint -q "$root/dev" || mount --bind /dev "$root/dev"
  trap 'umount "$root/proc" "$root/dev"' EXIT
  mkdir -p "$root/vesta"
  # Keeps times of modification, so that a second run compiles only what changed.
  git ls-files -z --cached --others --exclude-standard | xargs -0 ls -d 2>/dev/null | tar cf - -T - | tar xf - -C "$root/vesta"
  in_root sh -c 'cd /vesta && sh tools/install_packages.sh demo'
}

system_gcc() {
  in_root sh -c 'cd /vesta && ./run demo && ./run test'
}

system_shared() {
  in_root sh -c "cd /vesta && cmake --preset release -B build/shared -DBUILD_SHARED_LIBS=ON -DVESTA_BUILD_SPLATS=OFF \
    -DVESTA_BUILD_APPS=OFF -DVESTA_BUILD_TESTS=OFF -DVESTA_BUILD_BENCHMARKS=OFF &&
    cmake --build build/shared --parallel $jobs && cmake --install build/shared --prefix /opt/vesta &&
    cmake -G Ninja -S examples/registration -B build/shared_example -DCMAKE_PREFIX_PATH=/opt/vesta &&
    cmake --build build/shared_example && build/shared_example/registration &&
    ldd build/shared_example/registration | grep libvesta_solver.so."
}

system_clang() {
  packages clang lld
  in_root sh -c "cd /vesta && cmake --preset release -B build/clang -DCMAKE_CXX_COMPILER=clang++ -DVESTA_WARNINGS_AS_ERRORS=ON &&
    cmake --build build/clang --parallel $jobs && ctest --test-dir build/clang --parallel $jobs --output-on-failure"
}

system_arm64() {
  in_root sh -c 'dpkg --add-architecture arm64 && apt-get update -q >/tmp/apt.log'
  packages g++-aarch64-linux-gnu qemu-user libc6:arm64 libstdc++6:arm64 libxsimd-dev libeigen3-dev nlohmann-json3-dev \
    libnanoflann-dev libcpp-httplib-dev libtbb-dev:arm64 libfmt-dev:arm64 libjpeg-dev:arm64 libpng-dev:arm64 \
    libtiff-dev:arm64 libwebp-dev:arm64 libzip-dev:arm64 libzstd-dev:arm64 zlib1g-dev:arm64 libgflags-dev:arm64 \
    libgoogle-glog-dev:arm64 libceres-dev:arm64 libgtest-dev:arm64 libgmock-dev:arm64
  in_root sh -c "cd /vesta && cmake --preset release -B build/arm64 -DCMAKE_SYSTEM_NAME=Linux \
    -DCMAKE_SYSTEM_PROCESSOR=aarch64 -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++ \
    -DCMAKE_LIBRARY_ARCHITECTURE=aarch64-linux-gnu -DCMAKE_CROSSCOMPILING_EMULATOR=qemu-aarch64 \
    -DVESTA_BUILD_BENCHMARKS=OFF &&
    cmake --build build/arm64 --parallel $jobs --target tests/kernels/all tests/solver/all tests/problems/all &&
    ctest --test-dir build/arm64 --parallel $jobs --output-on-failure --label-regex unit --label-exclude data"
}

make_root
for system in "${@:-gcc shared clang arm64}"; do
  for name in $system; do
    printf '\n== %s\n' "$name"
    "system_$name"
  done
done
