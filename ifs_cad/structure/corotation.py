"""Large movements of small strains: quads that carry their frames along.

Every quad is seen from a frame that moves with it: its nodes' displacements and rotations against
that frame stay small, and the linear matrix holds for them. How the frame itself turns with the
nodes is exact and gives the geometric stiffness.

Source: C. A. Felippa and B. Haugen, "A unified formulation of small-strain corotational finite
elements", Computer Methods in Applied Mechanics and Engineering 194 (2005): projector, internal
forces and tangent; its moment-correction term, which only the speed of convergence knows, is left
out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ifs_cad.structure.surface import element_frames
from ifs_cad.types import FloatArray
from ifs_cad.vectors import length

SMALL_ANGLE = 1e-3  # radians, below which a series is more exact than the formula it expands


@dataclass(frozen=True, eq=False)
class State:
    """Quads in a deformed shape.

    Attributes
    ----------
    forces : (e, 24) float, what it takes to hold the nodes, in global axes, N and N mm
    tangents : (e, 24, 24) float, their change with displacements and spins, symmetric part
    strained : (e, 24) float
        Displacements and rotations seen from the moving frames, in the axes in which the quads
        were made.
    """

    forces: FloatArray
    tangents: FloatArray
    strained: FloatArray


@dataclass(frozen=True, eq=False)
class Corotation:
    """Quads before they move. Made by `corotation_of`.

    Attributes
    ----------
    frames : (e, 3, 3) float, their axes in rows
    flat : (e, 4, 3) float, their nodes seen from their frames, mm
    local : (e, 24, 24) float, their stiffness matrices in their frames
    """

    frames: FloatArray
    flat: FloatArray
    local: FloatArray

    def state(self, corners: FloatArray, rotations: FloatArray) -> State:
        """Return forces and tangents in a deformed shape.

        Parameters
        ----------
        corners : (e, 4, 3) float, where the nodes are now, mm
        rotations : (e, 4, 3, 3) float, how far they have turned
        """
        count = len(corners)
        frames = element_frames(corners)
        seen = _seen(corners, frames)
        turned = frames[:, None] @ rotations @ self.frames.transpose(0, 2, 1)[:, None]
        strained = np.stack([seen - self.flat, rotation_vectors(turned)], axis=2)
        inner = (self.local @ strained.reshape(count, 24, 1))[:, :, 0]

        # spins of the nodes to changes of their rotation vectors
        change = np.zeros((count, 4, 2, 3, 4, 2, 3))
        for node in range(4):
            change[:, node, 0, :, node, 0, :] = np.eye(3)
            change[:, node, 1, :, node, 1, :] = _changes(strained[:, node, 1])
        spin = _frame_spins(seen)
        projector = _projectors(seen, spin)
        seen_to_strain = change.reshape(count, 24, 24) @ projector
        outer = (seen_to_strain.transpose(0, 2, 1) @ inner[:, :, None])[:, :, 0]

        twist = _skew(outer.reshape(count, 4, 2, 3))  # of forces and of moments
        both = twist.reshape(count, 24, 3)
        moves = twist.copy()
        moves[:, :, 1] = 0.0
        tangent = seen_to_strain.transpose(0, 2, 1) @ self.local @ seen_to_strain
        tangent -= both @ spin
        tangent -= (
            spin.transpose(0, 2, 1) @ moves.reshape(count, 24, 3).transpose(0, 2, 1) @ (projector)
        )
        tangent = (tangent + tangent.transpose(0, 2, 1)) / 2
        blocks = _blocks(frames)
        back = blocks.transpose(0, 2, 1)
        made = np.einsum("eji,enkj->enki", self.frames, strained)
        return State(
            forces=(back @ outer[:, :, None])[:, :, 0],
            tangents=back @ tangent @ blocks,
            strained=made.reshape(count, 24),
        )


def corotation_of(corners: FloatArray, matrices: FloatArray) -> Corotation:
    """Return quads that carry their frames along.

    Parameters
    ----------
    corners : (e, 4, 3) float, mm
    matrices : (e, 24, 24) float, in global axes
    """
    frames = element_frames(corners)
    blocks = _blocks(frames)
    local = blocks @ matrices @ blocks.transpose(0, 2, 1)
    return Corotation(frames, _seen(corners, frames), local)


def rotation_matrices(vectors: FloatArray) -> FloatArray:
    """Return the rotations about (..., 3) vectors by their lengths in radians, (..., 3, 3)."""
    angle = length(vectors)[..., None, None]
    small = angle < SMALL_ANGLE
    safe = np.where(small, 1.0, angle)
    sine = np.where(small, 1 - angle**2 / 6, np.sin(safe) / safe)
    cosine = np.where(small, 0.5 - angle**2 / 24, (1 - np.cos(safe)) / safe**2)
    skew = _skew(vectors)
    return np.asarray(np.eye(3) + sine * skew + cosine * (skew @ skew))


def rotation_vectors(matrices: FloatArray) -> FloatArray:
    """Return the inverse of `rotation_matrices` for angles below a half turn."""
    twice = np.stack(
        [
            matrices[..., 2, 1] - matrices[..., 1, 2],
            matrices[..., 0, 2] - matrices[..., 2, 0],
            matrices[..., 1, 0] - matrices[..., 0, 1],
        ],
        axis=-1,
    )
    sine = length(twice)[..., None] / 2
    cosine = (np.trace(matrices, axis1=-2, axis2=-1)[..., None] - 1) / 2
    angle = np.arctan2(sine, cosine)
    small = angle < SMALL_ANGLE
    ratio = np.where(small, 1 + angle**2 / 6, angle / np.where(small, 1.0, sine))
    return np.asarray(twice / 2 * ratio)


def _changes(vectors: FloatArray) -> FloatArray:
    """Return how rotation vectors change with spins added on the left, (..., 3, 3)."""
    angle = length(vectors)[..., None, None]
    small = angle < SMALL_ANGLE
    half = np.where(small, 1.0, angle) / 2
    share = np.where(small, 1 / 12 + angle**2 / 720, (1 - half / np.tan(half)) / (4 * half**2))
    skew = _skew(vectors)
    return np.asarray(np.eye(3) - skew / 2 + share * (skew @ skew))


def _seen(corners: FloatArray, frames: FloatArray) -> FloatArray:
    apart = corners - corners.mean(axis=1, keepdims=True)
    return np.asarray(np.einsum("eij,enj->eni", frames, apart))


def _frame_spins(seen: FloatArray) -> FloatArray:
    """Return how frames spin with their nodes' displacements, (e, 3, 24), all in the frames."""
    spin = np.zeros((len(seen), 3, 4, 2, 3))
    one, other = seen[:, 2] - seen[:, 0], seen[:, 3] - seen[:, 1]  # diagonals, level in the frame
    double = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    for axis, sign in ((0, 1), (1, 1)):
        lift_one, lift_other = sign * other[:, axis] / double, sign * one[:, axis] / double
        spin[:, axis, 2, 0, 2] = -lift_one
        spin[:, axis, 0, 0, 2] = lift_one
        spin[:, axis, 3, 0, 2] = lift_other
        spin[:, axis, 1, 0, 2] = -lift_other
    side = seen[:, 1] - seen[:, 0]
    spin[:, 2] = (side[:, 2] / side[:, 0])[:, None, None, None] * spin[:, 0]
    spin[:, 2, 1, 0, 1] += 1 / side[:, 0]
    spin[:, 2, 0, 0, 1] -= 1 / side[:, 0]
    return spin.reshape(len(seen), 3, 24)


def _projectors(seen: FloatArray, spin: FloatArray) -> FloatArray:
    """Return what movements leave when seen from the moving frames, (e, 24, 24)."""
    count = len(seen)
    carried = np.zeros((count, 4, 2, 3, 3))
    carried[:, :, 0] = -_skew(seen)
    carried[:, :, 1] = np.eye(3)
    mean = np.zeros((4, 2, 3, 4, 2, 3))
    mean[:, 0, :, :, 0, :] = np.eye(3)[None, :, None, :] / 4
    return np.asarray(np.eye(24) - mean.reshape(24, 24) - carried.reshape(count, 24, 3) @ spin)


def _blocks(frames: FloatArray) -> FloatArray:
    """Return (e, 24, 24) with the frames along the diagonal."""
    blocks = np.zeros((len(frames), 8, 3, 8, 3))
    for place in range(8):
        blocks[:, place, :, place, :] = frames
    return blocks.reshape(len(frames), 24, 24)


def _skew(vectors: FloatArray) -> FloatArray:
    """Return the matrices of cross products with (..., 3) vectors."""
    skew = np.zeros((*vectors.shape, 3))
    x, y, z = np.moveaxis(vectors, -1, 0)
    skew[..., 0, 1], skew[..., 0, 2] = -z, y
    skew[..., 1, 0], skew[..., 1, 2] = z, -x
    skew[..., 2, 0], skew[..., 2, 1] = -y, x
    return skew
