#!/usr/bin/env bash
# Measures the effect of delay, jitter and loss on the rendered force: see impairment.py --help.
exec /usr/bin/python3 "$(dirname "$0")/impairment.py" "$@"
