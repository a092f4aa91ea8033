#!/usr/bin/env bash
# Runs the scripted clients of one language against a slave: one operates, if the language has such a client, while the other watches;
# or, with PALPATE_CLIENTS=feed, a driver feeds it tactile samples; with PALPATE_CLIENTS=devices one feeds
# it images and another drives its arm for a second.
#   run_clients.sh python|node SCRATCH_DIR SERVER [ARGUMENT ...]
# SERVER must print `listening on HOST:PORT` and end on SIGTERM. Exit code 77: the language's gRPC is
# not here and cannot be installed.
set -euo pipefail

language=$1
scratch=$2
shift 2
here=$(cd "$(dirname "$0")" && pwd)
examples=$(cd "$here/../../deploy/examples" && pwd)
mkdir -p "$scratch"

skip() {
  echo "skipped: $1"
  exit 77
}

case $language in
  python)
    # The python3 found first may be another than the one that has grpc.
    for candidate in /usr/bin/python3 python3; do
      if "$candidate" -c 'import grpc, google.protobuf, numpy' 2>/dev/null; then
        python=$candidate
        break
      fi
    done
    [[ -n ${python:-} ]] || skip "no python3 with grpc and numpy (apt-get install python3-grpcio python3-numpy)"
    command -v grpc_python_plugin >/dev/null || skip "no grpc_python_plugin"
    "$examples/../python/build.sh" "$scratch/python"
    export PYTHONPATH=$scratch/python PYTHONDONTWRITEBYTECODE=1
    operate=("$python" "$examples/operate.py")
    watch=("$python" "$examples/watch.py")
    feed=("$python" "$examples/feed_tactile.py" --check)
    images=("$python" "$examples/feed_images.py" --check)
    drive=("$python" "$examples/drive_arm.py" --duration 1 --home 0,0,0)
    ;;
  node)
    command -v npm >/dev/null || skip "no npm"
    cp "$examples/package.json" "$scratch/"
    npm install --prefix "$scratch" --no-audit --no-fund --ignore-scripts --silent >&2 || skip "npm could not install the packages"
    export NODE_PATH=$scratch/node_modules
    watch=(node "$examples/watch.js")
    ;;
  *)
    echo "usage: run_clients.sh python|node SCRATCH_DIR SERVER [ARGUMENT ...]" >&2
    exit 2
    ;;
esac

# shellcheck source=listening.sh
source "$here/listening.sh"
start_listening "$scratch/server.log" "$@"
trap stop_listening EXIT

if [[ ${PALPATE_CLIENTS:-} == feed ]]; then
  "${feed[@]}" "$address"
  exit
fi

if [[ ${PALPATE_CLIENTS:-} == devices ]]; then
  "${images[@]}" "$address"
  "${drive[@]}" "$address"
  exit
fi

"${watch[@]}" "$address" &
watcher=$!
result=0
[[ -z ${operate:-} ]] || "${operate[@]}" "$address" || result=1
wait "$watcher" || result=1
exit "$result"
