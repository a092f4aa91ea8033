#!/usr/bin/env bash
# Installs missing packages on Debian 12 and 13: those of palpate-slave and palpate-master, and those of the named parts.
# usage: deploy/install.sh [insertion] [cameras] [clouds] [mesher] [training] [view] [page] [plots] [python] [packages] [tests] [bare] [fuzz] [gcc]
#   view: npm, which installs three.js and uPlot of the operator's page   page: view, the browser of its tests, and the tool that joins images
#   plots: matplotlib of palpate.plot   python: the Python package with its models, and pip that builds it   packages: deploy/package.sh   tests: all parts and the packages of their tests   bare: tests of the packages in a bare Debian
#   fuzz: packages of the fuzzers   gcc: the second compiler of the tests
set -euo pipefail
# shellcheck source=progress.sh
source "$(dirname "$0")/progress.sh"

fail() { echo "install.sh: $1" >&2; exit 1; }
system=$(. /etc/os-release 2>/dev/null && echo "${ID:-} ${VERSION_ID:-}") || system=
untried=
case $system in
  "debian 12") clang=16 ;;  # `clang` is 14, in which lambdas cannot capture structured bindings
  "debian 13") clang=19 ;;
  "ubuntu 24.04") clang=18 untried=yes ;;
  *) fail "this system is '${system:-unknown}': expected Debian 12 or 13, or Ubuntu 24.04. Debian 12 and 13 were tried. deploy/demo.sh --no-install builds where the packages are already installed" ;;
esac

packages=("clang-$clang" cmake ninja-build protobuf-compiler protobuf-compiler-grpc libprotobuf-dev libgrpc++-dev libeigen3-dev
          libopencv-core-dev libopencv-imgproc-dev libopencv-calib3d-dev libopencv-video-dev libpng-dev libjpeg-dev libyaml-cpp-dev libcli11-dev
          libspdlog-dev nlohmann-json3-dev libboost-dev libmetis-dev liblapacke-dev libopenblas0-pthread zlib1g-dev
          libzstd-dev libnats-dev)
# palpate-cameras.so: videos, cameras, images other than PNG and JPEG; without the base plugins no GStreamer pipeline ends in an appsink.
cameras=(libopencv-videoio-dev gstreamer1.0-plugins-base)
insertion=(python3)                   # motion and figures of the embryo demo
training=(python3-torch python3-scipy python3-numpy python3-grpcio python3-protobuf)  # python3 -m palpate.train
clouds=(libpcl-dev)                   # palpate-slave evaluate
mesher=(gmsh)                         # fills closed surfaces with tetrahedra; takes 0.2 GB
plots=(python3-matplotlib python3-numpy)  # python3 -m palpate.plot
python=(pybind11-dev python3-dev python3-venv python3-pip python3-setuptools python3-wheel python3-numpy python3-grpcio python3-protobuf)
# Debian's node is installed only if there is none, because a newer one from another source conflicts with it.
want_npm() {
  command -v node >/dev/null || packages+=(nodejs)
  command -v npm >/dev/null || packages+=(npm)
}
for part in "$@"; do
  case $part in
    insertion) packages+=("${insertion[@]}") ;;
    view) want_npm ;;
    page) packages+=(chromium webp); want_npm ;;
    cameras) packages+=("${cameras[@]}") ;;
    clouds) packages+=("${clouds[@]}") ;;
    mesher) packages+=("${mesher[@]}") ;;
    plots) packages+=("${plots[@]}") ;;
    python) packages+=("${python[@]}") ;;
    training) packages+=("${training[@]}") ;;
    tests)
      packages+=("${cameras[@]}" "${clouds[@]}" "${mesher[@]}" "${training[@]}" libgtest-dev libgmock-dev libbenchmark-dev clang-format
                 clang-tidy "libclang-rt-$clang-dev" python3 mypy python3-grpcio python3-numpy python3-protobuf python3-serial python3-yaml iproute2 git openssl chromium universal-ctags
                 nats-server libspnav0 "${plots[@]}" "${python[@]}")
      want_npm ;;
    packages) packages+=("${python[@]}" dpkg-dev file) ;;
    bare) packages+=(debootstrap lintian python3-yaml iproute2) ;;
    fuzz) packages+=("libclang-rt-$clang-dev" python3) ;;
    gcc) packages+=(g++) ;;
    *) echo "install.sh: $part: expected insertion, cameras, clouds, mesher, training, view, page, plots, python, packages, tests, bare, fuzz, gcc" >&2; exit 2 ;;
  esac
done

missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

# The password is asked before the first line of the progress, which would overwrite the question.
if [ "$(id -u)" -ne 0 ]; then
  by_root="expected root or sudo. Let root run: apt-get update && apt-get install -y --no-install-recommends ${missing[*]}"
  command -v sudo >/dev/null || fail "$by_root"
  echo "install: ${#missing[@]} packages are missing, and sudo installs them"
  sudo true || fail "$by_root"
  exec sudo bash "$0" "$@"
fi
[ -z "$untried" ] || echo "install: Palpate as a whole was not tried on this system, $system. It was on Debian 12 and 13"
log=$(mktemp)
status="install: requesting ${missing[*]}"
follow() {  # follow LINE: shows the status of apt and keeps the other output
  case $1 in
    dlstatus:*) status="install: ${1##*:}" ;;
    pmstatus:*) IFS=: read -r _ name percent _ <<<"$1"; status="install: unpacking and setting up, ${percent%.*} % ($name)" ;;
    "") ;;
    *) echo "$1" >>"$log" ;;
  esac
  progress "$status, $SECONDS s"
}
# advice: prints what to do about a failure in the log.
advice() {
  case $(<"$log") in
    *"dpkg --configure -a"*) echo "an earlier installation was interrupted. Run: sudo dpkg --configure -a" ;;
    *"Could not get lock"* | *"Unable to lock"* | *"Unable to acquire"*) echo "another installation runs: wait until it has ended" ;;
    # `apt-get update` continues with old lists, and only the installation fails.
    *"Could not resolve"* | *"Could not connect"* | *"Unable to connect"* | *"connection timed out"* | *"Temporary failure"*)
      echo "apt does not reach its servers: check the network, and the proxy in /etc/apt/apt.conf.d" ;;
    *"Unable to locate package"* | *"has no installation candidate"*)
      echo "apt does not know all packages: check that /etc/apt/sources.list or /etc/apt/sources.list.d name main of $system" ;;
    *"No space left"* | *"enough free space"*) echo "the disk is full" ;;
    *) echo "apt-get failed, see above" ;;
  esac
}
apt() {
  # A separate descriptor, which apt-get closes for dpkg: its scripts print to descriptor 1 without a terminal.
  # LC_ALL: advice() reads the messages of apt-get.
  LC_ALL=C DEBIAN_FRONTEND=noninteractive apt-get "$@" -o APT::Status-Fd=3 3>&1 2>&1 </dev/null | each_line follow ||
    { progress_end "install: failed" >&2; cat "$log" >&2; fail "$(advice). Then run the command again"; }
}
apt update
apt install -y --no-install-recommends "${missing[@]}"
rm -f "$log"
progress_end "install: ${#missing[@]} packages and their dependencies, in $SECONDS s"
