#!/usr/bin/env bash
# Measures a row of RESULTS.md again, or lists which rows are older than their code. See results.py.
exec /usr/bin/python3 "$(dirname "$0")/results.py" "$@"
