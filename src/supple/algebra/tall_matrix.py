"""A matrix of many rows and few columns that can be extended by columns without a copy."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from supple.arrays import FloatArray

__all__ = ["TallMatrix"]


@dataclass(frozen=True, eq=False)
class TallMatrix:
    """Q = [Q_1 Q_2 ...], (n, m), stored as its blocks of columns.

    A single array would be copied for each extension, with both copies in memory: for a Krylov space of a
    large body that is gigabytes.

    blocks : (n, m_i) each
    """

    blocks: tuple[FloatArray, ...] = field(repr=False)

    @property
    def n_columns(self) -> int:
        """m, of all blocks together."""
        return sum(block.shape[1] for block in self.blocks)

    def with_block(self, block: FloatArray) -> TallMatrix:
        """[Q block]."""
        return TallMatrix((*self.blocks, block))

    def times(self, amounts: FloatArray) -> FloatArray:
        """Q amounts, (n, k) from (m, k)."""
        ends = np.cumsum([block.shape[1] for block in self.blocks])
        parts = np.split(amounts, ends[:-1])
        total = self.blocks[0] @ parts[0]
        for block, part in zip(self.blocks[1:], parts[1:], strict=True):
            total += block @ part
        return total

    def transposed_times(self, vectors: FloatArray) -> FloatArray:
        """Q^T vectors, (m, k) from (n, k)."""
        return np.vstack([block.T @ vectors for block in self.blocks])
