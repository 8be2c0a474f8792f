"""What a depsgraph shows many times, as one mesh at many places."""

from dataclasses import replace

import numpy as np

#: As the engine has it for files: smaller meshes, and those whose copies take little memory, are copied.
FEWEST_TRIANGLES, LEAST_SAVED = 64, 100_000
#: The volume of a matrix's axes over the cube of the longest, below which a mesh is too flat to be mapped there.
FLATTEST = 1e-3


def gathered(things):
    """Things by their keys, those of one part that are shown alike as one where that saves memory. It stands in the order where the first of
    them stood."""
    alike = {}
    for key, thing in things.items():
        if _is_place(thing.matrix):
            alike.setdefault(_kind(thing), []).append(key)
    made = {}
    for key, thing in things.items():
        keys = alike.get(_kind(thing), [])
        count = len(thing.part.triangles)
        if not _is_place(thing.matrix) or count < FEWEST_TRIANGLES or (len(keys) - 1) * count < LEAST_SAVED:
            made[key] = thing
        elif key == keys[0]:
            made[("places", *key)] = replace(thing, matrix=np.eye(4), places=np.stack([things[k].matrix for k in keys]))
    return made


def _kind(thing):
    return (id(thing.part), thing.look, thing.visible, thing.blocks)


def _is_place(matrix):
    axes = matrix[:3, :3]
    longest = np.linalg.norm(axes, axis=0).max()
    return abs(np.linalg.det(axes)) > FLATTEST * longest**3
