#!/bin/bash
# Run a kit on this machine's graphics processor, by EGL: a line for each unit program, then how long pictures take to start, then benches.
#     gpu-kit/run.sh [FOLDER]     logs, pictures and JSON go to FOLDER (default gpu-kit/out); the exit status is 1 if a program fails
# SPDX-License-Identifier: GPL-3.0-or-later
cd "$(dirname "$0")" || exit 2
out=$(realpath -m "${1:-out}")
mkdir -p "$out" || exit 2
export VXS_GL=egl LD_LIBRARY_PATH=$PWD/lib out
ldconfig -p 2>/dev/null | grep -q libEGL.so.1 || LD_LIBRARY_PATH+=:$PWD/loaders
# a driver of NVIDIA that a machine mounts beside its system
nvidia=/usr/local/nvidia
[ -d $nvidia/lib64 ] && LD_LIBRARY_PATH+=:$nvidia/lib64
[ -e $nvidia/share/glvnd/egl_vendor.d/10_nvidia.json ] && export __EGL_VENDOR_LIBRARY_FILENAMES=$nvidia/share/glvnd/egl_vendor.d/10_nvidia.json
seconds() { local begin=$EPOCHREALTIME status; "$@"; status=$?; took=$(echo "$EPOCHREALTIME $begin" | awk '{printf "%.1f s", $1 - $2}'); return $status; }
unit() {
    local name=${1#unit/} word=passed
    seconds timeout 200 "$1" >"$out/$name.txt" 2>&1 || word=FAILED
    grep -q "no OpenGL 4.5" "$out/$name.txt" && word="skipped: no OpenGL 4.5"
    echo "$name: $word, $took"
}
export -f seconds unit
jobs=$(nproc)
printf '%s\n' unit/* | xargs -P $((jobs < 12 ? jobs : 12)) -I{} bash -c 'unit {}' | tee "$out/unit.txt"
passed=$(grep -c ': passed' "$out/unit.txt") failed=$(grep -c ': FAILED' "$out/unit.txt") skipped=$(grep -c ': skipped' "$out/unit.txt")
echo "$passed passed, $failed failed, $skipped skipped"

bin/vxs scene city -o "$out/city.glb" --force --quiet && bin/vxs bake "$out/city.glb" -o "$out/city.vxs" --force --resolution 4096 --quiet
for fog in "" "--fog 0.01"; do
    for run in first second; do
        seconds bin/vxs render "$out/city.glb" "$out/city.vxs" -o "$out/city${fog:+_fog}.png" --force --quiet --gl egl --samples 1 --width 1920 --height 1080 $fog
        echo "vxs render city $fog, $run run: $took"
    done
done
seconds python3 tests/bench/lights.py --vxs bin/vxs --gl egl --size 1920x1080 --resolution 4096 --json "$out/lights.json" && echo "165 lights: $took"
python3 tests/bench/gpu.py --vxs bin/vxs --gpu bin/gpu --folder "$out/gpu" --json "$out/gpu.json" --size 1920x1080 --warm 100
[ "$failed" = 0 ]
