# Sourced by the tools: where this package lies (PACKAGE), where tools/setup builds it (WS), and where it may be built
# otherwise. PACKAGE is a checkout, or share/extperfc of an install space.
PACKAGE=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd -P)

folders_above() {  # nearest first
  local above=$PACKAGE
  while [ "$above" != / ]; do
    above=$(dirname "$above")
    echo "$above"
  done
}

default_workspace() {
  local above
  if [ ! -e "$PACKAGE/CMakeLists.txt" ]; then
    echo "${ROS_HOME:-$HOME/.ros}/extperfc"  # installed: only for what the tools write
    return
  fi
  while read -r above; do
    # Inside a catkin workspace rosrun searches the checkout for programs, except in build/.
    if [ -e "$above/.catkin_workspace" ] || [ -e "$above/.catkin_tools" ]; then
      echo "$PACKAGE/build/ws"
      return
    fi
  done < <(folders_above)
  echo "$PACKAGE/.ws"
}

WS=${EXTPERFC_WS:-$(default_workspace)}

# Devel and install spaces that may hold this package: that of tools/setup, the install space that the tools lie in, and
# those of the catkin workspace that the checkout lies in.
spaces() {
  local above
  echo "$WS/devel"
  echo "$PACKAGE/../.."
  while read -r above; do
    printf '%s\n' "$above"/{devel,install,devel_isolated/extperfc}
  done < <(folders_above)
}

# run_program NAME ARGUMENTS...: becomes a compiled program of this package.
run_program() {
  local name=$1 space all
  shift
  mapfile -t all < <(spaces)
  for space in "${all[@]}"; do
    [ ! -x "$space/lib/extperfc/$name" ] || exec "$space/lib/extperfc/$name" "$@"
  done
  echo "$name: the package is not built yet: run $PACKAGE/tools/setup, or catkin_make in your workspace" >&2
  exit "${NOT_BUILT:-1}"
}
