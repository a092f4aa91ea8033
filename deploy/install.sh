#!/usr/bin/env bash
# Installs what is missing on Debian 12: what the programs need, and with `tests` what their tests need too.
set -euo pipefail

packages=(g++ cmake ninja-build protobuf-compiler protobuf-compiler-grpc libprotobuf-dev libgrpc++-dev libeigen3-dev
          libopencv-dev libyaml-cpp-dev libcli11-dev libspdlog-dev nlohmann-json3-dev
          libmumps-seq-dev liblapack-dev libopenblas0-serial zlib1g-dev libpcl-dev)
if [ "${1:-}" = tests ]; then
  packages+=(libgtest-dev libgmock-dev libbenchmark-dev clang-format python3 python3-grpcio python3-protobuf
             iproute2 git)
  # A newer node from elsewhere conflicts with Debian's: install it only where there is none.
  command -v node >/dev/null || packages+=(nodejs)
  command -v npm >/dev/null || packages+=(npm)
fi

missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "install.sh: needs root or sudo to install: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
echo "installing ${#missing[@]} packages: ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
log=$(mktemp)
run() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive "$@" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }; }
run apt-get update
run apt-get install -y --no-install-recommends "${missing[@]}"
rm -f "$log"
