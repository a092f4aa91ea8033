#!/usr/bin/env bash
# Runs the whole system with one command: installs missing packages, builds, lets a simulated operator press a soft object
# through slave and master, and prints the forces.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: deploy/demo.sh [--duration S] [--scene NAME] [--out DIR] [--view]
  --duration S   length of the run [s], default 20; with --view: until Ctrl+C
  --scene NAME   a scene of deploy/scenes without .yaml, default silicone-block
  --view         operate with the mouse: serves the operator's page and prints its address
  --out DIR      folder for report.json, log.csv, shape.svg, slave.log and the offline runs, default build/demo
TEXT
}

duration= scene=silicone-block out= view=
while [ $# -gt 0 ]; do
  case $1 in
    --duration|--scene|--out)
      [ $# -ge 2 ] || { echo "demo.sh: $1 needs a value" >&2; usage >&2; exit 2; }
      case $1 in --duration) duration=$2 ;; --scene) scene=$2 ;; --out) out=$2 ;; esac
      shift 2 ;;
    --view) view=yes; shift ;;
    -h|--help) usage; exit 0 ;;
    *) echo "demo.sh: unknown option $1" >&2; usage >&2; exit 2 ;;
  esac
done
[ -n "$duration$view" ] || duration=20
[[ ${duration:-1} =~ ^[0-9]+(\.[0-9]+)?$ ]] || { echo "demo.sh: --duration $duration: accepted is a number of seconds" >&2; exit 2; }
if [ -n "$out" ]; then mkdir -p "$out"; out=$(cd "$out" && pwd); fi
cd "$(dirname "$0")/.."
# shellcheck source=progress.sh
source deploy/progress.sh
out=${out:-$PWD/build/demo}
mkdir -p "$out"
file=deploy/scenes/$scene.yaml
[ -f "$file" ] || { echo "demo.sh: --scene $scene: accepted is one of: $(cd deploy/scenes && ls ./*.yaml | sed 's#\./##; s/\.yaml//' | tr '\n' ' ')" >&2; exit 2; }

parts=() hand=(--device sim-hand) insertion=
if [ -z "$view" ] && grep -q '^  embryo:' "$file"; then insertion=yes parts=(insertion); fi

echo "== install and build (several minutes the first time)"
[ -z "$view" ] || parts+=(view)
deploy/install.sh "${parts[@]}"
[ -z "$view" ] || deploy/page.sh || echo "the page will have no 3D view and no charts"
deploy/build.sh release -DPALPATE_TESTS=OFF -- palpate-slave palpate-master
slave=build/release/bin/palpate-slave master=build/release/bin/palpate-master

echo
echo "== what will run"
plan=$($slave check "$file")
echo "$plan"

if [ -n "$insertion" ]; then
  echo
  echo "== offline run of the insertion, which locates the target for the playback"
  $slave process "$file" --pictures --out "$out/offline" | grep -v '^written'
  deploy/insertion.py hand "$out/offline" "$duration" "$out/hand.csv"
  hand=(--device "playback:$out/hand.csv")
fi

echo
if [ -n "$view" ]; then
  echo "== open the address of the page in a browser and drag the tool; ${duration:+$duration s, or }Ctrl+C ends it"
  hand=(--device pointer --view)
else
  echo "== the simulated operator presses for $duration s"
fi
[ -z "$duration" ] || hand+=(--duration "$duration")
said=$(mktemp)
$slave serve "$file" --listen 127.0.0.1:0 >"$said" 2>"$out/slave.log" &
pid=$!
trap 'rm -f "$said"; kill $pid 2>/dev/null || true' EXIT
for tenth in $(seq 900); do
  grep -q '^listening on ' "$said" && break
  kill -0 $pid 2>/dev/null || { echo "the slave did not start:" >&2; cat "$out/slave.log" >&2; exit 1; }
  [ $((tenth % 10)) -ne 0 ] || progress "starting the slave: $((tenth / 10)) s"
  sleep 0.1
done
address=$(sed -n 's/^listening on //p' "$said")
rm "$said"
[ -n "$address" ] || { echo "the slave did not answer within 90 s: see $out/slave.log" >&2; exit 1; }
progress_end "the slave is ready"
trap : INT  # the master ends on Ctrl+C, and this script continues
$master connect "$address" "${hand[@]}" --render local \
  --report "$out/report.json" --log "$out/log.csv" --shape "$out/shape.svg"
trap - INT
kill -TERM $pid 2>/dev/null || true
wait $pid || { echo "the slave did not stop cleanly: see $out/slave.log" >&2; exit 1; }
trap - EXIT
[ -z "$view" ] || { echo; echo "report: $out/report.json   every tick: $out/log.csv"; exit 0; }

if [ -n "$insertion" ]; then
  echo
  echo "== results of the insertion"
  deploy/insertion.py figures "$out/offline" "$out/log.csv" "$out"
  deploy/insertion.py models "$slave" "$file" "$out"
  echo
  echo "report: $out/report.json   every tick: $out/log.csv   slave's log: $out/slave.log"
  echo "images: $out/insertion.svg   force: $out/force-deformation.svg $out/force-time.svg $out/force-models.svg"
  exit 0
fi

echo
echo "== error of the estimate: the scene's own contacts offline, against the true force of the simulator"
if grep -q '^  *\(tactile\|points\):' "$file"; then
  $slave process "$file" --out "$out/offline" | grep -v '^written'
else
  own=$(sed -n 's/^info .* with \([0-9]*\) elements.*/\1/p' "$out/slave.log" | head -n 1)
  for elements in ${own:-180} 60; do
    echo "-- $elements boundary elements"
    $slave process "$file" --override model.elements=$elements --out "$out/offline-$elements" | grep -v '^written'
  done
fi
echo
echo "report: $out/report.json   every tick: $out/log.csv   slave's log: $out/slave.log"
echo "the object at its largest deflection: $out/shape-deepest.svg   at the end: $out/shape.svg"
