# Finds a Python interpreter of a given version that really runs. To be sourced by bash.
#
#   find_python 3.11   prints the path of an interpreter of Python 3.11 that can make virtual environments,
#                      or returns 1.
#
# A name on PATH proves nothing: pyenv leaves shims that refuse to run, and Debian splits ensurepip into a package of
# its own. So every candidate is started and asked. $PYTHON, when set, is asked first.

python_candidates() {
  local version=$1 name
  if [ -n "${PYTHON:-}" ]; then command -v "$PYTHON" || true; fi
  for name in "python$version" python3 python; do type -aP "$name" || true; done
  for name in \
    "${PYENV_ROOT:-$HOME/.pyenv}/versions/$version".*/bin/python \
    "${UV_PYTHON_INSTALL_DIR:-$HOME/.local/share/uv/python}/cpython-$version".*/bin/python \
    "/opt/homebrew/bin/python$version" "/usr/local/bin/python$version" \
    "/Library/Frameworks/Python.framework/Versions/$version/bin/python3"; do
    if [ -x "$name" ]; then echo "$name"; fi
  done
}

find_python() {
  local version=$1 candidate without_pip=
  while IFS= read -r candidate; do
    if ! "$candidate" -c "import sys; sys.exit(sys.version_info[:2] != tuple(map(int, '$version'.split('.'))))" \
      >/dev/null 2>&1 </dev/null; then continue; fi
    if "$candidate" -c "import venv, ensurepip" >/dev/null 2>&1 </dev/null; then
      "$candidate" -c "import sys; print(sys.executable)" # behind a shim
      return 0
    fi
    without_pip=$candidate
  done < <(python_candidates "$version")
  if [ -n "$without_pip" ]; then
    echo "$without_pip cannot make virtual environments (no ensurepip); on Debian: apt-get install python$version-venv" >&2
  fi
  return 1
}
