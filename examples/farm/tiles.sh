#!/bin/sh
# One picture in parts by GNU parallel: on this machine, or on those that PARALLEL names (PARALLEL='--sshlogin a,b --workdir .').
# A part that fails is tried three times. After an interruption the same command makes the missing ones.
#
#   tiles.sh SCENE OUT.exr PARTS [options of lobes render]
set -eu
scene=$1 out=$2 parts=$3
shift 3
lobes=${LOBES:-lobes}
folder=$out.parts
mkdir -p "$folder"
# Files are written whole or not at all, so an existing file is finished.
seq "$parts" | parallel --retries 3 --halt soon,fail=1 --joblog "$folder/log" --resume-failed --quote \
    "$lobes" render "$scene" --quiet --tiles "{}/$parts" -o "$folder/{}.exr" "$@"
"$lobes" merge "$folder"/*.exr -o "$out" --quiet
rm -r "$folder"
