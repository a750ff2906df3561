#!/usr/bin/env bash
# Installs the programs that read back what `msd export` writes, for tests/readers/ of msd-app, into
# a folder (default target/readers): numpy, VTK, Arrow and Blender as Python packages, and the
# validator of glTF. About 2 GB. Does nothing where they are there.
#
# Needs python3 of the version below with its venv, and npm (apt install python3-venv npm).
set -euo pipefail
cd "$(dirname "$0")/.."

folder=${1:-target/readers}
# Blender 5.0 is for Python 3.11 alone.
python=${MSD_PYTHON:-python3.11}
packages=(numpy==1.26.4 vtk==9.7.2 pyarrow==21.0.0 bpy==5.0.1)
validator=gltf-validator@2.0.0-dev.3.10

done=$folder/installed.txt
wanted="${packages[*]} $validator"
[ "$(cat "$done" 2>/dev/null)" != "$wanted" ] || exit 0
mkdir -p "$folder"
"$python" -m venv "$folder/python"
"$folder/python/bin/pip" install --quiet --disable-pip-version-check "${packages[@]}"
npm install --silent --no-audit --no-fund --prefix "$folder" "$validator"
echo "$wanted" >"$done"
