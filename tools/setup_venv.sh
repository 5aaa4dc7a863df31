#!/usr/bin/env bash
# Makes or completes a virtual environment: the bpy module, what the named layers list, and this project (editable).
#
#   tools/setup_venv.sh VENV SERIES LAYER...
#
#   VENV     folder, such as .venv
#   SERIES   4.2, 4.5, 5.0 or 5.2: the Blender series of the bpy module;
#            lts: 4.5 with Python 3.11, else 5.2 with Python 3.13; newest: 5.2 where Python 3.13 is found, else 5.0
#   LAYER    names of further files in requirements/: test, lint, figures, bench, peers
#
# Each step leaves a stamp with a digest of what it was made from, so nothing is done twice, a changed requirement is
# installed again, and an environment that was cut off half-way is finished or made anew.
# Exit code 3: no suitable Python was found.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/find_python.sh

[ $# -ge 2 ] || { sed -n '4,14s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2; exit 2; }
venv=$1 series=$2
shift 2
stamps=$venv/.stamps

digest() { # digest FILE...: one short line for the content of the files
  cat "$@" | git hash-object --stdin 2>/dev/null || cat "$@" | cksum
}

python_of_series() {
  case $1 in
    4.2 | 4.5 | 5.0) echo 3.11 ;;
    5.2) echo 3.13 ;;
    *) echo "Unknown Blender series '$1': 4.2, 4.5, 5.0, 5.2, lts or newest" >&2; exit 2 ;;
  esac
}

resolve_series() {
  case $1 in
    lts)
      if [ -n "${PYTHON:-}" ]; then
        case $("$PYTHON" -c 'import sys; print("%d.%d" % sys.version_info[:2])') in
          3.11) echo 4.5 ;;
          3.13) echo 5.2 ;;
          *) echo "PYTHON=$PYTHON is neither Python 3.11 (Blender 4.5) nor 3.13 (Blender 5.2)" >&2; exit 2 ;;
        esac
      elif [ -f "$stamps/series" ]; then cat "$stamps/series"
      elif find_python 3.11 >/dev/null; then echo 4.5
      elif find_python 3.13 >/dev/null; then echo 5.2
      else echo "Neither Python 3.11 (Blender 4.5) nor 3.13 (Blender 5.2) was found; PYTHON=... names one" >&2; exit 3; fi ;;
    newest) if find_python 3.13 >/dev/null 2>&1; then echo 5.2; else echo 5.0; fi ;;
    *) echo "$1" ;;
  esac
}

pip_install() { # pip_install PURPOSE ARGUMENT...; everything is pinned, so nothing is resolved
  local purpose=$1 started=$SECONDS
  shift
  echo "  $purpose"
  if ! "$venv/bin/python" -m pip install -q --no-input --disable-pip-version-check --no-deps "$@" </dev/null; then
    echo "  once more, after a failure: $purpose" >&2
    "$venv/bin/python" -m pip install -q --no-input --disable-pip-version-check --no-deps "$@" </dev/null
  fi
  echo "    done in $((SECONDS - started)) s"
}

is_stamped() { [ "$(cat "$stamps/$1" 2>/dev/null)" = "$2" ]; }

series=$(resolve_series "$series")
version=$(python_of_series "$series")
identity="$PWD/$venv bpy $series"

if ! is_stamped created "$identity" || ! "$venv/bin/python" -c "import pip" >/dev/null 2>&1; then
  if ! python=$(find_python "$version"); then
    echo "Python $version is needed for the bpy module of Blender $series and was not found." >&2
    exit 3
  fi
  echo "Making $venv with $("$python" --version) ($python) for Blender $series"
  rm -rf "$venv"
  "$python" -m venv "$venv"
  mkdir -p "$stamps"
  echo "$identity" >"$stamps/created"
  echo "$series" >"$stamps/series"
fi

for layer in "bpy-$series" "$@"; do
  file=requirements/$layer.txt
  if is_stamped "$layer" "$(digest "$file")"; then continue; fi
  rm -f "$stamps/$layer"
  pip_install "$(sed -n '1s/^# //p' "$file") [$file]" -r "$file"
  if [ "$layer" = "bpy-$series" ] && ! "$venv/bin/python" -c "import bpy" >/dev/null 2>"$stamps/bpy.log"; then
    tools/system_libraries.sh || exit 1
    echo "The bpy module does not load:" >&2
    cat "$stamps/bpy.log" >&2
    exit 1
  fi
  digest "$file" >"$stamps/$layer"
done

if ! is_stamped project "$(digest pyproject.toml)" || [ ! -x "$venv/bin/dichromatic" ]; then
  pip_install "This project, editable, with the command 'dichromatic'." --no-build-isolation -e .
  digest pyproject.toml >"$stamps/project"
fi
