#!/bin/sh
# The frames FROM to before TO of an animation by GNU parallel, as tiles.sh. Frames that are there, made of the same scene by the same
# options, are kept.
#
#   frames.sh SCENE OUT.exr FROM TO [options of lobes render]
set -eu
scene=$1 out=$2 from=$3 to=$4
shift 4
lobes=${LOBES:-lobes}
seq "$from" "$((to - 1))" | parallel --retries 3 --halt soon,fail=1 --quote \
    "$lobes" render "$scene" --quiet --frames '{}..{= $_ = $_ + 1 =}' -o "$out" "$@"
