# SPDX-License-Identifier: Apache-2.0
"""Parameter blocks: which entries of x form a block, and which blocks each row of residuals reads."""
import numpy as np


class Blocks:
    """The parameter blocks of a vector x. Entries that no residual reads belong to no block.

    block, entry: per entry of x, its block (or -1) and its place in the block. sizes: entries of each block.
    """

    def __init__(self, block, entry, sizes):
        self.block, self.entry, self.sizes = block, entry, sizes

    @staticmethod
    def from_rows(num_variables, variables_of_rows, seed=0):
        """Entries that always occur together form a block.

        variables_of_rows: for each group of rows, its arrays of indices into x. Two entries get one block if they occur
        in the same rows. Each row has a random number; entries with equal sums of these numbers occur in the same rows
        (for a million entries, the chance of an error is about 1e-12).
        """
        random = np.random.default_rng(seed)
        sums = np.zeros((3, num_variables))
        for variables in variables_of_rows:
            rows = len(variables[0]) if variables else 0
            for k in range(3):
                # Integers below 2^26, so that sums are exact.
                numbers = random.integers(1, 1 << 26, rows).astype(float)
                for indices in variables:
                    sums[k] += np.bincount(indices, numbers, num_variables)
        block = np.full(num_variables, -1)
        used = np.flatnonzero(sums[0])
        if used.size:
            _, first, inverse = np.unique(sums[:, used], axis=1, return_index=True, return_inverse=True)
            rank = np.empty(len(first), int)
            rank[np.argsort(first)] = np.arange(len(first))  # blocks in the order of their first entries
            block[used] = rank[np.asarray(inverse).ravel()]
        return Blocks(block, *_entries(block))

    @staticmethod
    def single(num_variables):
        """One block per entry."""
        return Blocks(np.arange(num_variables), np.zeros(num_variables, int), np.ones(num_variables, int))

    def order(self):
        """The entries of x that belong to blocks, block after block."""
        used = np.flatnonzero(self.block >= 0)
        return used[np.lexsort((self.entry[used], self.block[used]))]


def _entries(block):
    used = np.flatnonzero(block >= 0)
    order = used[np.argsort(block[used], kind="stable")]
    sizes = np.bincount(block[used]) if used.size else np.zeros(0, int)
    entry = np.zeros(len(block), int)
    starts = np.cumsum(sizes) - sizes
    entry[order] = np.arange(len(order)) - np.repeat(starts, sizes)
    return entry, sizes


class Layout:
    """Rows whose variables have the same places in the blocks that they read.

    rows: their numbers. blocks: array (rows, blocks per row). sizes: of these blocks. places: per variable of the row,
    its position in the row's blocks, one block after another.
    """

    def __init__(self, rows, blocks, sizes, places):
        self.rows, self.blocks, self.sizes, self.places = rows, blocks, sizes, places


def layouts(blocks, variables):
    """The Layouts of a group of rows. variables: arrays of indices into x, one per variable slot."""
    indices = np.stack(variables, axis=1)
    block, entry = blocks.block[indices], blocks.entry[indices]
    left = np.arange(len(indices))
    result = []
    while left.size:
        rows = left[_like_first(block[left], entry[left], blocks.sizes)]
        first = _first_slots(block[rows[0]])
        leaders = np.unique(first)
        sizes = blocks.sizes[block[rows[0], leaders]]
        starts = dict(zip(leaders, np.cumsum(sizes) - sizes))
        places = [int(starts[f] + e) for f, e in zip(first, entry[rows[0]])]
        result.append(Layout(rows, block[np.ix_(rows, leaders)], [int(s) for s in sizes], places))
        left = np.setdiff1d(left, rows, assume_unique=True)
    return result


def _first_slots(block):
    """Per slot of one row, the first slot with the same block."""
    _, first, inverse = np.unique(block, return_index=True, return_inverse=True)
    return first[inverse]


def _like_first(block, entry, sizes):
    """True for each row whose slots have the places of the first row's slots."""
    first = _first_slots(block[0])
    same = (block == block[:, first]).all(axis=1) & (entry == entry[0]).all(axis=1)
    leaders = np.unique(first)
    same &= (sizes[block[:, leaders]] == sizes[block[0, leaders]]).all(axis=1)
    different = np.sort(block[:, leaders], axis=1)
    return same & (np.diff(different, axis=1) != 0).all(axis=1)
