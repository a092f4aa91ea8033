#!/usr/bin/env bash
# Runs slave and master in two network namespaces that are joined by a veth pair. They reach each other by address.
#   namespaces.sh SCRATCH_DIR 'SLAVE COMMAND' 'MASTER COMMAND'
# In both commands ADDRESS is replaced by the slave's address, for example
#   namespaces.sh /tmp/x 'palpate-slave serve s.yaml --listen ADDRESS --insecure' \
#                        'palpate-master connect ADDRESS --insecure --duration 4'
# The exit code is the master's; 77: namespaces are not permitted here.
set -euo pipefail

if [[ $# -ne 3 ]]; then
  sed -n '2,6p' "$0" >&2
  exit 2
fi
scratch=$1
slave_command=$2
master_command=$3
mkdir -p "$scratch"

# A user without privileges may still be permitted to make namespaces.
if [[ -z ${PALPATE_UNSHARED:-} ]] && ! ip netns add "palpate-probe-$$" 2>/dev/null; then
  if unshare --user --map-root-user --net --mount true 2>/dev/null; then
    PALPATE_UNSHARED=1 exec unshare --user --map-root-user --net --mount "$0" "$@"
  fi
  echo "skipped: network namespaces are not permitted here"
  exit 77
fi
ip netns delete "palpate-probe-$$" 2>/dev/null || true
if [[ -n ${PALPATE_UNSHARED:-} ]]; then
  mount -t tmpfs tmpfs /run || { echo "skipped: no mounts in a namespace"; exit 77; }
fi

slave_net=palpate-slave-$$
master_net=palpate-master-$$
remove() {
  ip netns delete "$slave_net" 2>/dev/null || true
  ip netns delete "$master_net" 2>/dev/null || true
}
trap remove EXIT

join() {
  ip netns add "$slave_net"
  ip netns add "$master_net"
  ip link add palpate-s netns "$slave_net" type veth peer name palpate-m netns "$master_net"
  ip -n "$slave_net" address add 10.77.0.1/24 dev palpate-s
  ip -n "$master_net" address add 10.77.0.2/24 dev palpate-m
  ip -n "$slave_net" link set palpate-s up
  ip -n "$master_net" link set palpate-m up
}
if ! join 2>"$scratch/ip.log"; then
  echo "skipped: namespaces cannot be joined: $(tail -n 1 "$scratch/ip.log")"
  exit 77
fi

slave=(bash -c "exec ${slave_command//ADDRESS/10.77.0.1:50051}")
master=(bash -c "exec ${master_command//ADDRESS/10.77.0.1:50051}")
log=$scratch/slave.log
ip netns exec "$slave_net" "${slave[@]}" >"$log" 2>&1 &
server=$!
stop() {
  kill -TERM "$server" 2>/dev/null || true
  wait "$server" 2>/dev/null || true
  remove
}
trap stop EXIT
for _ in $(seq 600); do
  grep -q '^listening on ' "$log" || { sleep 0.1; continue; }
  ip netns exec "$master_net" "${master[@]}"
  exit
done
echo "the slave did not start:"
cat "$log"
exit 1
