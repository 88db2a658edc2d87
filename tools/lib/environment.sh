# Sourced by the tools: a known environment, whatever the user's shell holds. Sets REPO and WS.
# Debian's programs come first on the PATH, because another python3 there would break ROS.
. "$(dirname "${BASH_SOURCE[0]}")/places.sh"
REPO=$PACKAGE
export PATH=/usr/sbin:/usr/bin:/sbin:/bin
unset PYTHONPATH PYTHONHOME PYTHONSTARTUP VIRTUAL_ENV PYENV_VERSION CMAKE_PREFIX_PATH ROS_PACKAGE_PATH
export PYTHONDONTWRITEBYTECODE=1
export ROS_LANG_DISABLE=genlisp   # nobody here reads messages in Lisp
export LC_ALL=C.UTF-8
export CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime

say() { printf '\033[1m%s\033[0m\n' "$*" >&2; }
die() { printf 'error: %s\n' "$*" >&2; exit 1; }

# The environment of the space that this package is built in; call after tools/setup.
enter_workspace() {
  local space all
  mapfile -t all < <(spaces)
  for space in "${all[@]}"; do
    if [ -f "$space/.catkin" ] && [ -d "$space/share/extperfc" ]; then
      set +u
      # shellcheck disable=SC1091
      . "$space/setup.bash"
      set -u
      return
    fi
  done
  die "the workspace $WS is not built yet: run tools/setup"
}
