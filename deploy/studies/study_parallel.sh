#!/usr/bin/env bash
# A study in shards by GNU parallel on one machine, and its merge. Run again after an interruption, it continues.
# usage: study_parallel.sh SCENE OUT [SHARDS [JOBS]]    default: 8 shards, one job for each processor
# Jobs that run side by side slow each other down: with JOBS 1 the times are those of a machine with one task.
set -euo pipefail
[ $# -ge 2 ] || { sed -n '3s/^# //p' "$0" >&2; exit 2; }
scene=$1 out=$2 shards=${3:-8} jobs=${4:-100%}
export OPENBLAS_NUM_THREADS=1
seq "$shards" | parallel --will-cite --quote --jobs "$jobs" --retries 3 \
  palpate-slave study "$scene" --shard "{}/$shards" --out "$out"
palpate-slave study "$scene" --merge "$out"
