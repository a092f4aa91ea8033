#!/usr/bin/env bash
# Copies the project into a minimal Debian, runs a command there as a new user would, and prints its duration [s].
# usage: tests/bare_root.sh FOLDER COMMAND... (as root, with debootstrap; FOLDER must not exist, and stays)
#   tests/bare_root.sh /tmp/bare deploy/install.sh
#   tests/bare_root.sh /tmp/bare deploy/demo.sh --duration 5
# SUITE names another release than that of this machine, for example trixie. MIRROR names another archive. CACHE: a folder that keeps the system's packages.
set -euo pipefail

[ $# -ge 2 ] || { sed -n '2,6s/^# //p' "$0" >&2; exit 2; }
project=$(cd "$(dirname "$0")/.." && pwd)
root=$1; shift
[ ! -e "$root" ] || { echo "bare_root.sh: $root exists already" >&2; exit 2; }
suite=${SUITE:-$(. /etc/os-release && echo "$VERSION_CODENAME")}
mirror=${MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' | head -n 1)}

mkdir -p "$root" ${CACHE:+"$CACHE"}
debootstrap --variant=minbase ${CACHE:+--cache-dir="$(cd "$CACHE" && pwd)"} "$suite" "$root" "$mirror" >"$root.log" 2>&1 ||
  { tail -n 20 "$root.log" >&2; exit 1; }
cp /etc/resolv.conf "$root/etc/resolv.conf"
[ ! -e /etc/apt/apt.conf.d/proxy ] || cp /etc/apt/apt.conf.d/proxy "$root/etc/apt/apt.conf.d/"
mkdir "$root/palpate"
git -C "$project" ls-files -z | (cd "$project" && tar --null -T - -c) | tar -x -C "$root/palpate"

trap 'umount "$root/proc" "$root/dev"' EXIT
mount -t proc proc "$root/proc"
mount --bind /dev "$root/dev"
# Installed programs must not start services.
printf '#!/bin/sh\nexit 101\n' >"$root/usr/sbin/policy-rc.d"
chmod +x "$root/usr/sbin/policy-rc.d"
begin=$(date +%s.%N)
code=0
chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 \
  sh -c 'cd /palpate && exec "$@"' sh "$@" </dev/null || code=$?
end=$(date +%s.%N)
echo "$(awk "BEGIN {printf \"%.0f\", $end - $begin}") s, exit $code: $*"
exit $code
