#!/usr/bin/env bash
# The container's second stage without a container engine: a root that holds what is installed and the files of the
# packages that deploy/runtime_packages.sh names, and nothing else. The slave must start there and answer.
# Needs root or user namespaces; else it skips (77).
set -euo pipefail

bin=${PALPATE_BIN:-$(dirname "$0")/../../build/release/bin}
project=$(cd "$(dirname "$0")/../.." && pwd)
become=()
[ "$(id -u)" -eq 0 ] || become=(unshare --map-root-user)
"${become[@]}" chroot / true 2>/dev/null || { echo "skipped: no permission to change the root"; exit 77; }

root=$(mktemp -d)
pid=
trap '[ -z "$pid" ] || kill "$pid" 2>/dev/null; rm -rf "$root"' EXIT
DESTDIR=$root/image cmake --install "$bin/.." --prefix /usr >/dev/null
rm -rf "$root/image/usr/lib/palpate"  # parts that a container has only where it is asked for them
packages=$("$project/deploy/runtime_packages.sh" "$root/image")
# Debian's own links from /lib to /usr/lib stand before any file.
mkdir -p "$root/usr/lib" "$root/usr/lib64" "$root/proc" "$root/tmp"
ln -s usr/lib "$root/lib"
ln -s usr/lib64 "$root/lib64"
# shellcheck disable=SC2086
dpkg -L $packages | sort -u | while read -r file; do
  if [ -f "$file" ] || [ -L "$file" ]; then echo "$file"; fi
done | grep -v '^/usr/share/' | tar -c -P -h --no-recursion -T - | tar -x -P -C "$root" --transform 's#^/##'
cp -r "$root/image/." "$root/"
# Which of several BLAS a system has chosen is told by links of no package.
ldd "$root"/usr/bin/palpate-* | awk '$2 == "=>" {print $3}' | sort -u | while read -r library; do
  [[ $(readlink "$library") != /etc/alternatives/* ]] || cp -L "$library" "$root$library"
done

mkfifo "$root/out"
"${become[@]}" chroot "$root" /usr/bin/palpate-slave serve /usr/share/palpate/scenes/silicone-block.yaml \
  --listen 127.0.0.1:0 >"$root/out" 2>"$root/err" &
pid=$!
exec 3<"$root/out"
read -r -t 60 line <&3 || { cat "$root/err" >&2; exit 1; }
/usr/bin/python3 - "${line#listening on }" <<'PYTHON'
import sys, grpc
with grpc.insecure_channel(sys.argv[1]) as channel:
    answer = channel.unary_unary("/grpc.health.v1.Health/Check")(b"", timeout=30)
assert answer == b"\x08\x01", answer  # HealthCheckResponse{status: SERVING}
PYTHON
echo "$(wc -w <<<"$packages") packages; the slave answers from them: $line"
