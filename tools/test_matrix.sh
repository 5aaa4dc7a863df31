#!/usr/bin/env bash
# Tests the add-on on several versions of Blender and compares the pictures they made.
#
#   tools/test_matrix.sh [SERIES...]    default: 4.2 4.5 5.0 5.2; "newest" is the newest that this machine can have
#
# A series whose Python is not found is skipped and said so; fewer than two tested series are a failure.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/find_python.sh

[ $# -gt 0 ] || set -- 4.2 4.5 5.0 5.2
artifacts=$PWD/artifacts/matrix
rm -rf "$artifacts"
mkdir -p "$artifacts"
export DICHROMATIC_ARTIFACTS=$artifacts

tested=() skipped=() failed=()
for series in "$@"; do
  if [ "$series" = newest ]; then
    if find_python 3.13 >/dev/null 2>&1; then series=5.2; else series=5.0; fi
  fi
  venv=.venv-$series
  if [ "$(cat .venv/.stamps/series 2>/dev/null)" = "$series" ]; then venv=.venv; fi # it is there already
  echo "== Blender $series ($venv)"
  status=0
  tools/setup_venv.sh "$venv" "$series" test || status=$?
  if [ $status = 3 ]; then skipped+=("$series"); continue; fi
  [ $status = 0 ] || exit $status
  if "$venv/bin/python" -m pytest tests/addon -p no:cacheprovider; then tested+=("$series"); else failed+=("$series"); fi
done

echo "== Matrix"
echo "tested: ${tested[*]:-none}; failed: ${failed[*]:-none}; skipped for want of a Python: ${skipped[*]:-none}"
[ ${#failed[@]} = 0 ] || exit 1
[ ${#tested[@]} -ge 2 ] || { echo "A matrix needs at least two versions of Blender." >&2; exit 1; }
"$venv/bin/python" -m tools.compare_versions "$artifacts" ${#tested[@]}
