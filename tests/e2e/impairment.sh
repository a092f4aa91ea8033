#!/usr/bin/env bash
# What delay, jitter and loss do to what the hand feels: see impairment.py --help.
exec /usr/bin/python3 "$(dirname "$0")/impairment.py" "$@"
