#!/usr/bin/env bash
# The bpy wheels link to shared libraries of the desktop that a bare Linux system lacks.
#
#   tools/system_libraries.sh             says which are missing; exit code 1 when one is
#   tools/system_libraries.sh --install   installs them with apt-get where it can (as root)
set -euo pipefail

# soname:Debian package, as ldd names them for bpy 4.2 to 5.2
LIBRARIES="libX11.so.6:libx11-6 libXrender.so.1:libxrender1 libXxf86vm.so.1:libxxf86vm1 libXfixes.so.3:libxfixes3
  libXi.so.6:libxi6 libxkbcommon.so.0:libxkbcommon0 libSM.so.6:libsm6 libICE.so.6:libice6 libGL.so.1:libgl1
  libgomp.so.1:libgomp1"

[ "$(uname -s)" = Linux ] || exit 0
known=$(PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null) || exit 0

packages=()
for pair in $LIBRARIES; do
  case $known in *"${pair%%:*} "*) ;; *) packages+=("${pair#*:}") ;; esac
done
[ ${#packages[@]} -gt 0 ] || exit 0

if [ "${1:-}" = --install ] && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
  echo "Installing the shared libraries that bpy needs: ${packages[*]}"
  apt-get update -qq
  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${packages[@]}" </dev/null
  exit 0
fi
echo "Shared libraries that the bpy module needs are missing. On Debian or Ubuntu:" >&2
echo "    sudo apt-get install ${packages[*]}" >&2
exit 1
