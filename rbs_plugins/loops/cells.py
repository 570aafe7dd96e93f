"""Small loops over the cells of a lattice that no law takes part in: copying to cells, looking for bonds, damage."""

from __future__ import annotations

from math import inf


def gather(begin, end, thread, source, target, cells, first, moved):
    """Copies rows (n, d) of nodes to cells (d, size), and says for each range whether anything is not zero."""
    for c in range(begin, end):
        some = False
        for k in range(target.shape[0]):
            row = target[k]
            for i in range(first[c], first[c + 1]):
                value = source[i, k]
                row[cells[i]] = value
                some = some | (value != 0)
        moved[c] = some
    return 0


def gather_dense(begin, end, thread, source, target, first, moved, margin):
    """The same where every cell holds a node."""
    for c in range(begin, end):
        rows = source[first[c] : first[c + 1]]
        some = False
        for k in range(target.shape[0]):
            row = target[k, first[c] + margin : first[c + 1] + margin]
            for q in range(row.size):
                value = rows[q, k]
                row[q] = value
                some = some | (value != 0)
        moved[c] = some
    return 0


def carry(begin, end, thread, source, target, cells):
    """Copies values (n,) of nodes to their cells."""
    for i in range(begin, end):
        target[cells[i]] = source[i]
    return 0


def finish(begin, end, thread, targets, out, cell, start, cells, first, margin, last, chunk):
    """Adds sums by cell (s, size), times `cell`, to rows (n, s) of nodes (sets the rows, if `start`), and clears them.

    Answers 1 if any sum is not finite.
    """
    wrong = 0
    for c in range(begin, end):
        a = margin + c * chunk
        e = min(a + chunk, last)
        for k in range(out.shape[1]):
            row = targets[k]
            for i in range(first[c], first[c + 1]):
                value = row[cells[i]]
                wrong = wrong | (not (abs(value) < inf))
                out[i, k] = value * cell if start != 0 else out[i, k] + value * cell
            row[a:e] = 0
    return wrong


def finish_dense(begin, end, thread, targets, out, cell, start, first, margin):
    """The same where every cell holds a node."""
    wrong = 0
    for c in range(begin, end):
        rows = out[first[c] : first[c + 1]]
        for k in range(out.shape[1]):
            row = targets[k, first[c] + margin : first[c + 1] + margin]
            for q in range(row.size):
                value = row[q]
                wrong = wrong | (not (abs(value) < inf))
                row[q] = 0
                rows[q, k] = value * cell if start != 0 else rows[q, k] + value * cell
    return wrong


def survey(begin, end, thread, bits, steps, masks, alive, failed, margin, last, width, chunk):
    """Says for each range and step whether any bond ahead holds; forgets which steps have failed."""
    for c in range(begin, end):
        a = margin + c * chunk
        e = min(a + chunk, last)
        for k in range(steps.size):
            failed[c, k] = 0
            mask, row = masks[k], bits[k // width, a:e]
            some = row[0] & mask
            for q in range(row.size):
                some = some | (row[q] & mask)
            alive[c, k] = some != 0
    return 0


def count_volumes(total, left, there_ahead, there_back, holds_ahead, holds_back, volume_ahead, volume_back, mask):
    """Adds the volumes of the neighbors ahead and back of a step, and of those whose bonds hold."""
    for q in range(total.size):
        v, w = volume_ahead[q], volume_back[q]
        total[q] += (v if there_ahead[q] & mask != 0 else 0.0) + (w if there_back[q] & mask != 0 else 0.0)
        left[q] += (v if holds_ahead[q] & mask != 0 else 0.0) + (w if holds_back[q] & mask != 0 else 0.0)


def broken_share(
    begin, end, thread, present, bits, steps, masks, volume, cells, first, out, scratch, margin, last, width, chunk
):
    """Damage: out = 1 - sum of the intact neighbor volumes over the sum of all; volume by cell."""
    for c in range(begin, end):
        a = margin + c * chunk
        e = min(a + chunk, last)
        total, left = scratch[thread, 0, : e - a], scratch[thread, 1, : e - a]
        total[:] = 0.0
        left[:] = 0.0
        for k in range(steps.size):
            word, s = k // width, steps[k]
            there, holds = present[word], bits[word]
            count_volumes(
                total, left, there[a:e], there[a - s : e - s], holds[a:e], holds[a - s : e - s],
                volume[a + s : e + s], volume[a - s : e - s], masks[k],
            )  # fmt: skip
        for i in range(first[c], first[c + 1]):
            q = cells[i] - a
            out[i] = 1.0 - left[q] / total[q] if total[q] > 0 else 0.0
    return 0
