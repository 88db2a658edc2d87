# Sourced by the tools: a known environment, whatever the user's shell holds. Sets REPO and WS.
# Debian's programs come first on the PATH, because another python3 there would break ROS.
REPO=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd -P)
WS=${EXTPERFC_WS:-$REPO/.ws}
export PATH=/usr/sbin:/usr/bin:/sbin:/bin
unset PYTHONPATH PYTHONHOME PYTHONSTARTUP VIRTUAL_ENV PYENV_VERSION CMAKE_PREFIX_PATH ROS_PACKAGE_PATH
export PYTHONDONTWRITEBYTECODE=1
export ROS_LANG_DISABLE=genlisp   # nobody here reads messages in Lisp
export LC_ALL=C.UTF-8
export CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime

say() { printf '\033[1m%s\033[0m\n' "$*" >&2; }
die() { printf 'error: %s\n' "$*" >&2; exit 1; }

# The workspace's own environment; call after tools/setup.
enter_workspace() {
  [ -f "$WS/devel/setup.sh" ] || die "the workspace $WS is not built yet: run tools/setup"
  set +u
  # shellcheck disable=SC1091
  . "$WS/devel/setup.bash"
  set -u
}
