# shellcheck shell=bash
# Functions for a progress line. On a terminal it is overwritten, elsewhere it is printed every ten seconds.

progress_last=-10

# progress TEXT
progress() {
  if [ -t 1 ]; then
    printf '\r\033[K%.*s' "$((${COLUMNS:-$(tput cols 2>/dev/null || echo 80)} - 1))" "$1"
  elif [ $((SECONDS - progress_last)) -ge 10 ]; then
    echo "$1"
    progress_last=$SECONDS
  fi
}

# progress_end TEXT: prints the final line.
progress_end() {
  [ ! -t 1 ] || printf '\r\033[K'
  echo "$1"
  progress_last=-10
}

# each_line FUNCTION: calls FUNCTION with every line of the input, and with an empty string after each second without one.
each_line() {
  local part='' line result
  while true; do
    IFS= read -r -t 1 line && result=0 || result=$?
    part+=$line
    if [ $result -eq 0 ]; then
      "$1" "$part"
      part=
    elif [ $result -gt 128 ]; then
      "$1" ""
    else
      return 0
    fi
  done
}
