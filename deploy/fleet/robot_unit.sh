#!/usr/bin/env bash
# Makes a template of the slave's unit, for several slaves: palpate-slave@NAME reads /etc/palpate/robots/NAME.conf.
# usage: robot_unit.sh UNIT >/etc/systemd/system/palpate-slave@.service
#   UNIT   /usr/lib/systemd/system/palpate-slave.service of the package, or deploy/palpate-slave.service
set -euo pipefail
[ $# -eq 1 ] || { sed -n '2,4s/^# //p' "$0" >&2; exit 2; }
sed -e 's|^Description=.*|Description=Palpate slave of %i|' \
  -e 's|^EnvironmentFile=.*|EnvironmentFile=/etc/palpate/robots/%i.conf|' \
  -e 's|^StateDirectory=.*|StateDirectory=palpate-slave/%i|' -- "$1"
