#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the Debian package and tests it in a minimal Debian 12, as root:   tools/check_package.sh BUILD_DIR WORK_DIR
# Needs debootstrap and a Debian mirror. The test trains the demo's scene for a few iterations.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build_dir=$(cd "$1" && pwd)
mkdir -p "$2"
work=$(cd "$2" && pwd)
root=$work/root

say() { printf -- '-- %s\n' "$*"; }

say "package"
cmake --build "$build_dir" --target vesta vesta_manual vesta_demo_scene >"$work/build.log" || { cat "$work/build.log"; exit 1; }
(cd "$build_dir" && cpack -G DEB >"$work/cpack.log") || { cat "$work/cpack.log"; exit 1; }
package=$(find "$build_dir" -maxdepth 1 -name 'vesta_*.deb' -printf '%f\n')
dpkg-deb -f "$build_dir/$package" Depends

if [[ ! -x $root/usr/bin/apt-get ]]; then
  say "minimal Debian 12"
  debootstrap --variant=minbase bookworm "$root" >"$work/debootstrap.log"
fi
cp "$build_dir/$package" "$root/root/"
cp /etc/resolv.conf "$root/etc/resolv.conf"
"$build_dir/vesta_demo_scene" --out "$root/root/scene"
mount --bind /proc "$root/proc"
trap 'umount "$root/proc"' EXIT

say "install, run and remove the package there"
chroot "$root" bash -euc "
  export DEBIAN_FRONTEND=noninteractive
  cd /root
  apt-get update -qq
  apt-get install -y -qq --no-install-recommends ./$package >install.log || { cat install.log; exit 1; }
  vesta --version
  vesta doctor scene
  vesta train scene --out out --iterations=50 --quiet
  test -s out/point_cloud.ply && test -s out/metrics.json && test -s out/report.html
  test -s /usr/share/man/man1/vesta.1 && test -s /usr/share/bash-completion/completions/vesta
  apt-get remove -y -qq vesta >remove.log
  test ! -e /usr/bin/vesta
"
say "$package was installed, ran and was removed"
