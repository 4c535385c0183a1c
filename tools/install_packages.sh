#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Installs missing Debian 12 packages that a build of vesta needs. If none is missing, it needs neither the network nor
# root.
#   tools/install_packages.sh [demo] [tutorial] [python] [ci]
# demo: also for the demo's plot; tutorial: for tools/tutorial.sh; python: for the Python package and its tests;
# ci: the tools of CI
set -eu

packages="
  g++ cmake ninja-build pkg-config python3
  libtbb-dev libxsimd-dev libfmt-dev nlohmann-json3-dev libnanoflann-dev
  libjpeg-dev libpng-dev libtiff-dev libwebp-dev libzip-dev libzstd-dev zlib1g-dev
  libgflags-dev libgoogle-glog-dev libcpp-httplib-dev
  libceres-dev libeigen3-dev libgtest-dev libgmock-dev"

for group in "$@"; do
  case $group in
    demo) packages="$packages python3-matplotlib" ;;
    tutorial) packages="$packages colmap ffmpeg" ;;
    python) packages="$packages python3-dev python3-numpy python3-scipy pybind11-dev" ;;
    ci) packages="$packages git ccache clang clang-format clang-tidy doxygen libclang-rt-dev libopenmpi-dev openmpi-bin" ;;
    *) echo "install_packages.sh: unknown group '$group'; the groups are demo, tutorial, python and ci" >&2; exit 2 ;;
  esac
done

if ! command -v dpkg-query >/dev/null 2>&1; then
  echo "Not a Debian system: no package was installed. Install the equivalents of these Debian packages:"
  echo "$packages"
  exit 0
fi

missing=
for package in $packages; do
  status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null) || status=none
  [ "$status" = installed ] || missing="$missing $package"
done
if [ -z "$missing" ]; then
  echo "Packages: all are installed."
  exit 0
fi

as_root=
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null 2>&1; then
    echo "Packages are missing, and installing them needs root or sudo. As root, run:" >&2
    echo "  apt-get update && apt-get install --no-install-recommends$missing" >&2
    exit 1
  fi
  as_root=sudo
fi

echo "Packages: installing$missing"
$as_root apt-get update -q || {
  echo "install_packages.sh: apt-get update failed; check the network and /etc/apt/sources.list" >&2
  exit 1
}
# shellcheck disable=SC2086  # word splitting is intended
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $missing
