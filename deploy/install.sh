#!/usr/bin/env bash
# Installs missing packages on Debian 12: those of palpate-slave and palpate-master, and those of the named parts.
# usage: deploy/install.sh [insertion] [films] [openni] [calibration] [clouds] [mesher] [training] [view] [page] [studies] [packages] [tests] [bare] [fuzz] [gcc]
#   view: npm, which installs three.js and uPlot of the operator's page   page: view, the browser of its tests, and the tool that joins images
#   studies: tools that run shards of a study   packages: deploy/package.sh   tests: all parts and the packages of their tests   bare: tests of the packages in a bare Debian
#   fuzz: packages of the fuzzers   gcc: the second compiler of the tests
set -euo pipefail
# shellcheck source=progress.sh
source "$(dirname "$0")/progress.sh"

packages=(clang-16 cmake ninja-build protobuf-compiler protobuf-compiler-grpc libprotobuf-dev libgrpc++-dev libeigen3-dev
          libopencv-core-dev libopencv-imgproc-dev libpng-dev libjpeg62-turbo-dev libyaml-cpp-dev libcli11-dev
          libspdlog-dev nlohmann-json3-dev libboost-dev libmetis-dev liblapacke-dev libopenblas0-pthread zlib1g-dev
          libzstd-dev libnats-dev)
# palpate-films.so: films, cameras, pictures other than PNG and JPEG; without the base plugins no GStreamer pipeline ends in an appsink.
films=(libopencv-videoio-dev gstreamer1.0-plugins-base)
openni=(libopenni2-dev)               # palpate-openni.so: depth cameras
calibration=(libopencv-calib3d-dev)   # palpate-slave calibrate
insertion=(python3)                   # motion and figures of the embryo demo
training=(python3-torch python3-scipy python3-numpy python3-grpcio python3-protobuf)  # python3 -m palpate.train
clouds=(libpcl-dev)                   # palpate-slave evaluate
mesher=(gmsh)                         # fills closed surfaces with tetrahedra; takes 0.2 GB
studies=(parallel snakemake)          # deploy/studies; snakemake takes 0.7 GB
# A newer node from elsewhere conflicts with Debian's: installed only where there is none.
want_npm() {
  command -v node >/dev/null || packages+=(nodejs)
  command -v npm >/dev/null || packages+=(npm)
}
for part in "$@"; do
  case $part in
    insertion) packages+=("${insertion[@]}") ;;
    view) want_npm ;;
    page) packages+=(chromium webp); want_npm ;;
    films) packages+=("${films[@]}") ;;
    openni) packages+=("${openni[@]}") ;;
    calibration) packages+=("${calibration[@]}") ;;
    clouds) packages+=("${clouds[@]}") ;;
    mesher) packages+=("${mesher[@]}") ;;
    studies) packages+=("${studies[@]}") ;;
    training) packages+=("${training[@]}") ;;
    tests)
      packages+=("${films[@]}" "${openni[@]}" "${calibration[@]}" "${clouds[@]}" "${mesher[@]}" "${training[@]}" libgtest-dev libgmock-dev libbenchmark-dev ccache clang-format
                 clang-tidy libclang-rt-16-dev python3 mypy python3-grpcio python3-numpy python3-protobuf python3-serial iproute2 git openssl universal-ctags chromium
                 nats-server parallel)
      want_npm ;;
    packages) packages+=(python3 dpkg-dev file) ;;
    bare) packages+=(debootstrap lintian python3-yaml iproute2) ;;
    fuzz) packages+=(libclang-rt-16-dev python3) ;;
    gcc) packages+=(g++) ;;
    *) echo "install.sh: $part: expected insertion, films, openni, calibration, clouds, mesher, training, view, page, studies, packages, tests, bare, fuzz, gcc" >&2; exit 2 ;;
  esac
done

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
export DEBIAN_FRONTEND=noninteractive
log=$(mktemp)
status="install: requesting ${missing[*]}"
follow() {  # follow LINE: shows the status of apt, keeps the rest
  case $1 in
    dlstatus:*) status="install: ${1##*:}" ;;
    pmstatus:*) IFS=: read -r _ name percent _ <<<"$1"; status="install: unpacking and setting up, ${percent%.*} % ($name)" ;;
    "") ;;
    *) echo "$1" >>"$log" ;;
  esac
  progress "$status, $SECONDS s"
}
apt() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get "$@" -o APT::Status-Fd=1 2>&1 </dev/null | each_line follow ||
    { progress_end "install: failed" >&2; cat "$log" >&2; exit 1; }
}
apt update
apt install -y --no-install-recommends "${missing[@]}"
rm -f "$log"
progress_end "install: ${#missing[@]} packages and their dependencies, in $SECONDS s"
