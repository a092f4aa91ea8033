# Sourced: starts a program that prints `listening on HOST:PORT` when it is ready.

# start_listening LOG PROGRAM [ARGUMENT ...]: sets `server` (its pid) and `address`.
start_listening() {
  local log=$1
  shift
  : >"$log"  # so that it is there to be read
  "$@" >>"$log" 2>&1 &
  server=$!
  for _ in $(seq 600); do
    address=$(sed -n 's/^listening on //p' "$log")
    [[ -n $address ]] && return 0
    kill -0 "$server" 2>/dev/null || break
    sleep 0.1
  done
  echo "the server did not start:"
  cat "$log"
  stop_listening
  return 1
}

stop_listening() {
  kill -TERM "$server" 2>/dev/null || true
  wait "$server" 2>/dev/null || true
}
